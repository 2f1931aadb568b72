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

layout(std430, binding = PEL_STORE_WATER_TURNS) restrict readonly buffer turns_block { vec4 turns[]; };

// The phase function but for its peak at a scattering angle of cosine nu
// (pel_phase_rest).
vec3 phase(float nu)
{
    float at = sqrt(clamp(0.5 - 0.5 * nu, 0.0, 1.0)) * float(PEL_WATER_TURNS);
    int i = min(int(at), PEL_WATER_TURNS - 1);
    return mix(turns[i].rgb, turns[i + 1].rgb, at - float(i));
}

// (1 − e^(−x)) / x.
vec3 mean_decay(vec3 x)
{
    vec3 small = 1.0 - x * (0.5 - x * (1.0 / 6.0 - x / 24.0));
    return mix((1.0 - exp(-x)) / x, small, lessThan(abs(x), vec3(0.05)));
}

// Path of light that was scattered once into a direction of zenith cosine mu
// (> 0 downward) and arrives at depth z: eq. 7 over beta E. Twin of
// pel_transport_first_path.
vec3 first_path(int level, vec3 z, float sun_mu, float mu)
{
    vec3 c = full_extinction.rgb;
    vec3 sun = exp(-c * z / sun_mu);
    if (mu > 0.0) {
        vec3 x = c * z * (1.0 / mu - 1.0 / sun_mu);
        return z / mu * mix(exp(-c * z / mu) * mean_decay(-x), sun * mean_decay(x),
                            greaterThanEqual(x, vec3(0.0)));
    }
    vec3 rest = max(depth[level].x - z, vec3(0.0));
    return -rest / mu * sun * mean_decay(c * (1.0 / sun_mu - 1.0 / mu) * rest);
}
