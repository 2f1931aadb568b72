#version 450 core
// What a sensor shows that is not the eye's grey: photons counted in low light,
// or heat (PEL_THERMAL) from the layers of the surface in each pixel.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/tone.glsl"

layout(location = 0) out vec4 color;
#ifdef PEL_THERMAL
// [0] x the sea's radiance, y the air's, z emissivity of the zenith, w
// extinction, 1/m; [1] x black, K; y 1 / K; z NETD, K; w the air, K; [2] x K
// that the Sun adds, xyz.. ; then for each hot spot its place from the eye and
// radius, its entity's number plus one and K.
layout(binding = PEL_UNIT_SENSE_ROUGH) uniform sampler2D rough_sea;
layout(binding = PEL_UNIT_SENSE_HEAT) uniform sampler2D heats;
layout(binding = PEL_UNIT_SENSE_PLANES) uniform sampler2D depths;
layout(binding = PEL_UNIT_SENSE_PLANES + 1) uniform sampler2D normals;
layout(binding = PEL_UNIT_SENSE_PLANES + 2) uniform sampler2D fresnels;
layout(binding = PEL_UNIT_SENSE_PLANES + 3) uniform sampler2D variances;
layout(binding = PEL_UNIT_SENSE_PLANES + 4) uniform sampler2D ids;
layout(binding = PEL_UNIT_SENSE_PLANES + 5) uniform sampler2D foams;
#else
// [0] rgb photons by radiance; w exposed light by photons; [1] rgb of the
// screen.
layout(binding = PEL_UNIT_RADIANCE) uniform sampler2D radiance;
#endif
layout(location = 0) uniform vec4 sense[PEL_SENSE_ALL];

// Two numbers in (0, 1) for a place on the lattice and a moment (O'Neill 2014).
vec2 chances(uvec2 p)
{
    uvec2 seed = uvec2(sensor_seed.xy);
    uvec2 got;
    uint state = p.x * 747796405u + 2891336453u;
    state = (state ^ (state >> 15u)) * 2246822519u + p.y * 3266489917u;
    state = (state ^ (state >> 13u)) * 668265263u + (seed.x | seed.y << 16u) * 374761393u;
    for (int i = 0; i < 2; i++) {
        state = state * 747796405u + 2891336453u;
        uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
        got[i] = (word >> 22u) ^ word;
    }
    return (vec2(got >> 9u) + 0.5) / 8388608.0;
}

float gaussian(vec2 u)
{
    return sqrt(-2.0 * log(u.x)) * cos(2.0 * PI * u.y);
}

#ifdef PEL_THERMAL
float heat(float kelvin)
{
    const float most = float(PEL_SENSE_HEATS - 1);
    float at = clamp((kelvin - PEL_SENSE_LEAST_K) / (PEL_SENSE_MOST_K - PEL_SENSE_LEAST_K), 0.0, 1.0);
    float root = textureLod(heats, vec2((at * most + 0.5) / (most + 1.0), 0.5), 0.0).r;
    return root * root * root * root;
}

float temperature(float light)
{
    const float most = float(PEL_SENSE_HEATS - 1);
    float hottest = texelFetch(heats, ivec2(PEL_SENSE_HEATS - 1, 0), 0).r;
    float at = clamp(sqrt(sqrt(max(light, 0.0))) / hottest, 0.0, 1.0);
    return textureLod(heats, vec2((at * most + 0.5) / (most + 1.0), 0.5), 0.0).g;
}

// Twins of pel_thermal_masses and pel_thermal_sky.
float sky_heat(float sine)
{
    float s = clamp(sine, 0.0, 1.0);
    float deg = degrees(asin(s));
    float masses = min(1.0 / (s + 0.50572 * pow(deg + 6.07995, -1.6364)), 38.0);
    return sense[0].y * (1.0 - pow(1.0 - sense[0].z, masses));
}

float sea_heat(ivec2 at, vec3 n, vec3 dir)
{
    vec2 variance = texelFetch(variances, at, 0).rg;
    float mu = max(-dot(n, dir), 0.0);
    const vec2 nodes = vec2(PEL_SENSE_COSINES, PEL_SENSE_DEVIATIONS);
    vec2 place = clamp(vec2(sqrt(mu), sqrt(0.5 * (variance.x + variance.y)) / PEL_SENSE_DEVIATION_MOST), 0.0, 1.0);
    vec2 mean = textureLod(rough_sea, (place * (nodes - 1.0) + 0.5) / nodes, 0.0).rg;
    float up = clamp(reflect(dir, n).z + mean.y - mu, 0.02, 1.0);
    float emitted = mix(mean.x, 0.99, texelFetch(foams, at, 0).r);
    return emitted * sense[0].x + (1.0 - emitted) * sky_heat(up);
}

// Paint, rock and sand: as warm as the air, but for what the Sun adds.
float matt_heat(ivec2 at, vec3 n, vec3 place)
{
    float kelvin = sense[1].w + sense[2].w * max(dot(n, sense[2].xyz), 0.0);
    float id = texelFetch(ids, at, 0).r;
    for (int i = 0; i < PEL_SENSE_SPOTS; i++) {
        vec4 spot = sense[PEL_SENSE_UNIFORMS + 2 * i];
        vec2 what = sense[PEL_SENSE_UNIFORMS + 2 * i + 1].xy;
        vec3 off = place - spot.xyz;
        kelvin += id > 0.5 && id == what.x ? what.y * exp(-dot(off, off) / max(spot.w * spot.w, 1e-6)) : 0.0;
    }
    const float emitted = 0.93;
    float around = mix(sense[0].x, sky_heat(max(n.z, 0.3)), clamp(0.5 + 0.5 * n.z, 0.0, 1.0));
    return emitted * heat(kelvin) + (1.0 - emitted) * around;
}

float sensed_light(ivec2 at, uvec2 place)
{
    vec3 ray = pixel_ray(lattice(at));
    vec3 dir = ray / sqrt(dot(ray, ray));
    vec3 n = texelFetch(normals, at, 0).xyz;
    float light;
    if (n == vec3(0.0)) {
        light = sky_heat(dir.z);
    } else {
        bool sea = texelFetch(fresnels, at, 0).r > 0.0;
        // The mean sea is far enough away for the air before it.
        float range = sea ? distance_to_ground(eye.x, dir.z) : texelFetch(depths, at, 0).r;
        range = range < 0.0 ? sqrt(2.0 * planet.x * eye.x) : range;
        light = sea ? sea_heat(at, n, dir) : matt_heat(at, n, dir * range);
        float through = exp(-sense[0].w * range);
        light = light * through + sense[0].y * (1.0 - through);
    }
    float kelvin = temperature(light) + sense[1].z * gaussian(chances(place));
    return clamp((kelvin - sense[1].x) * sense[1].y, 0.0, 1.0);
}
#else
// A number of photons of this mean: Knuth's way below 16, above it a Gaussian,
// whose third moment is off by 1 / sqrt(mean).
float counted(float mean, uvec2 place)
{
    vec2 u = chances(place);
    if (mean > 16.0) {
        return max(floor(mean + sqrt(mean) * gaussian(u) + 0.5), 0.0);
    }
    float chance = exp(-mean);
    float sum = chance;
    float n = 0.0;
    for (int i = 0; i < 64 && u.x > sum; i++) {
        n += 1.0;
        chance *= mean / n;
        sum += chance;
    }
    return n;
}

float sensed_light(ivec2 at, uvec2 place)
{
    vec3 ray = pixel_ray(lattice(at));
    vec3 light = with_glare(texelFetch(radiance, at, 0).rgb, ray / sqrt(dot(ray, ray)));
    float photons = counted(max(dot(sense[0].rgb, light), 0.0), place);
    float shown = photons * sense[0].w * exposing.g;
    return sensor_seed.w == float(PEL_TONE_LINEAR) ? shown : tone_curve(max(shown, 1e-9));
}
#endif

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    uvec2 place = uvec2(ivec2(floor(pixel.zw)) + at + 65536);
    float light = clamp(sensed_light(at, place), 0.0, 1.0);
#ifdef PEL_THERMAL
    color = vec4(sensed(vec3(light), place), 1.0);
#else
    color = vec4(sensed(srgb(vec3(light)), place) * sense[1].rgb, 1.0);
#endif
}
