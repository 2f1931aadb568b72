// The water as its maps are made (optics/waterkernel.h).

// The buffer of the answers, by level of depth.
const int SINGLE = PEL_PART_SINGLE;
const int SECOND = PEL_PART_SECOND;
const int BEYOND = PEL_PART_HIGHER; // and SECOND, until they are told apart
const int BOTTOM = PEL_PART_BOTTOM;
const int STRAIGHT = PEL_PART_STRAIGHT;
const int PARTS = 5;

int kernel_at(int level, int part, int mode, int beam, int sight)
{
    return (((level * PARTS + part) * PEL_WATER_MODES + mode) * PEL_WATER_NODES + beam) *
               PEL_WATER_NODES + sight;
}

// Henyey and Greenstein's phase function at a scattering angle of cosine nu.
vec3 phase(float nu)
{
    vec3 g = asymmetry.rgb;
    vec3 d = 1.0 + g * g - 2.0 * g * nu;
    return (1.0 - g * g) / (12.566370614 * d * sqrt(d));
}

// (1 − e^(−x)) / x.
vec3 mean_decay(vec3 x)
{
    vec3 small = 1.0 - x * (0.5 - x * (1.0 / 6.0 - x / 24.0));
    return mix((1.0 - exp(-x)) / x, small, lessThan(abs(x), vec3(0.05)));
}
