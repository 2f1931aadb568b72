// The water's light for an eye in it (optics/underlight.h). Depths z are below
// the mean sea, m, sights unit vectors away from the eye.

layout(binding = PEL_UNIT_UNDER) uniform sampler2DArray under_map; // a layer a light and level of depth

// Of the eye: below the surface there where waves are as high as it is deep.
float under_depth()
{
    return under_drift.x;
}

// What clouds and fog leave of the water's light; set before any is looked up.
vec3 under_veil = vec3(1.0);

void veil_water()
{
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    veil_lights_evenly();
    under_veil = water_veiled(vec2(0.0));
#endif
}

// Of every light, at a row of the map.
vec3 under_fetch(vec2 toward, float row, float z)
{
    float level = clamp(log2(1.0 + max(z, 0.0) * under_levels.x) * under_levels.y, 0.0, under_levels.z);
    float below = min(floor(level), under_levels.z - 1.0);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        float column = azimuth_from(i, toward) * (float(PEL_UNDER_COLUMNS - 1) / PI);
        vec2 uv = (vec2(column, row) + 0.5) / vec2(PEL_UNDER_COLUMNS, 2 * PEL_UNDER_ROWS + 2);
        float layer = float(i * PEL_UNDER_LEVELS) + below;
        sum += mix(textureLod(under_map, vec3(uv, layer), 0.0).rgb,
                   textureLod(under_map, vec3(uv, layer + 1.0), 0.0).rgb, level - below);
    }
    return sum * exp(-under_fall.rgb * max(z, 0.0)) * under_veil;
}

// What the water alone sends along a sight at a depth: all that was scattered,
// but for the lights' beams scattered once.
vec3 water_alone(vec3 sight, float z)
{
    float elevation = 0.5 * PI - fast_acos(min(abs(sight.z), 1.0));
    float x = pow(max(elevation * (2.0 / PI), 0.0), 1.0 / PEL_UNDER_POWER) * float(PEL_UNDER_ROWS - 1);
    vec3 way = 1.0 - exp(-under_scaled.rgb * (max(z, 0.0) / max(sight.z, 1e-3)));
    return under_fetch(sight.xy, x + (sight.z >= 0.0 ? 0.0 : float(PEL_UNDER_ROWS)), z) *
           (sight.z >= 0.0 ? way : vec3(1.0));
}

// Irradiance of level planes from above, without the lights' unscattered beams,
// and from below.
vec3 under_flux(float z, float side)
{
    return under_fetch(vec2(1.0, 0.0), float(2 * PEL_UNDER_ROWS) + side, z);
}

vec3 under_left(float s)
{
    return exp(-under_scaled.rgb * s);
}

// What s m of it add to light from beyond. A transfer equation holds along the
// line, whatever enters it at its ends.
vec3 water_between(vec3 sight, float z, float s)
{
    return max(water_alone(sight, z) - under_left(s) * water_alone(sight, z - s * sight.z), vec3(0.0));
}

vec3 under_phase(float nu)
{
    float x = sqrt(fast_acos(clamp(nu, -1.0, 1.0)) / PI) * float(PEL_UNDER_TURNS);
    int i = min(int(x), PEL_UNDER_TURNS - 1);
    return exp2(mix(under_turns[i].rgb, under_turns[i + 1].rgb, x - float(i)));
}

// Irradiance normal to a light's beam at a depth.
vec3 under_beam(int i, float z)
{
    return beam_there(i) * (under_beams[i].w * exp(-under_scaled.rgb * (max(z, 0.0) / under_beams[i].z)));
}

// (1 − e^(−x)) / x.
vec3 mean_left(vec3 x)
{
    vec3 far = (1.0 - exp(-max(x, vec3(-60.0)))) / mix(x, vec3(1.0), lessThan(abs(x), vec3(1e-3)));
    return mix(far, 1.0 - 0.5 * x, lessThan(abs(x), vec3(1e-3)));
}

// A light's beam scattered once, on s m: I eq. 7 for any sight.
vec3 sun_between(int i, vec3 sight, float z, float s)
{
    vec4 to = under_beams[i];
    vec3 rate = under_scaled.rgb * (1.0 - sight.z / to.z);
    return under_beam(i, z) * under_scatter.rgb * under_phase(dot(to.xyz, sight)) * mean_left(rate * s) * s;
}

vec3 suns_between(vec3 sight, float z, float s)
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        sum += sun_between(i, sight, z, s);
    }
    return sum;
}

// Diffuse light on a face, and with the beams.
vec3 under_diffuse(vec3 n, float z)
{
    return mix(under_flux(z, 1.0), under_flux(z, 0.0), (0.5 + 0.5 * n.z) * (0.5 + 0.5 * n.z));
}

const float UNDER_FAR = 2000.0; // m: nothing is seen of what is farther

// To the surface or the bottom, both level.
float under_level_end(vec3 sight, float z)
{
    float s = sight.z > 0.0 ? max(z, 0.0) / sight.z : (under_ground.w - z) / max(-sight.z, 1e-6);
    return clamp(s, 0.0, UNDER_FAR);
}

// Down from the depth z, over a level bottom.
vec3 under_down(vec3 sight, float z)
{
    float s = under_level_end(sight, z);
    vec3 e = under_flux(under_ground.w, 0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        e += under_beam(i, under_ground.w) * under_beams[i].z;
    }
    return water_between(sight, z, s) + suns_between(sight, z, s) +
           under_left(s) * under_ground.rgb * e * (1.0 / PI);
}

// What an eye at this depth sees of the water under a level sea; what the
// meter takes. `map`: the sky that the sea mirrors.
vec3 under_level_seen(sampler2D map, vec3 sight, float z)
{
    if (sight.z <= 0.0) {
        return under_down(sight, z);
    }
    float n2 = refraction.g;
    float k = 1.0 - n2 * (1.0 - sight.z * sight.z);
    float cosine = sqrt(max(k, 0.0));
    vec3 mirrored = k > 0.0 ? facet_reflectance(cosine) : vec3(1.0);
    vec3 out_ = vec3(sight.xy * sqrt(n2), cosine);
    vec3 sky = textureLod(map, out_.xy / (1.0 + out_.z) * (0.5 / PEL_REFLECTION_HALF_WIDTH) + 0.5, 2.0).rgb;
    float s = under_level_end(sight, z);
    return water_between(sight, z, s) + suns_between(sight, z, s) +
           under_left(s) * (mirrored * under_down(vec3(sight.xy, -sight.z), 0.0) + (1.0 - mirrored) * n2 * sky);
}
