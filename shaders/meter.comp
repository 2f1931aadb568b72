#version 450 core
// The exposure of a view by what the windows of its meter see of sky and mean
// sea, and the glare of the lights in its lens.
#define PEL_METER
#include "lib/blocks.h"
#ifdef PEL_SPACE_WINDS
#include "lib/windhere.glsl"
#endif
#include "lib/together.glsl"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#ifndef PEL_SPACE
#include "lib/beam.glsl"
#endif
#include "lib/ray.glsl"
#include "lib/ross.glsl"
#include "lib/water.glsl"
#ifdef PEL_SPACE
#include "lib/space.glsl"
#endif
#include "lib/shade.glsl"
#include "lib/shaded.glsl"
#include "lib/foamlight.glsl"
#ifdef PEL_SPACE
#include "lib/spacesea.glsl"
#else
#include "lib/haze.glsl"
#endif
#include "lib/vision.glsl"

layout(local_size_x = PEL_GROUP_LINE) in;
layout(binding = PEL_UNIT_TRANSMITTANCE) uniform sampler2D transmittance;
layout(binding = PEL_UNIT_REFLECTION) uniform sampler2D reflection_map;
#ifdef PEL_UNDER
#include "lib/underlight.glsl"
#endif
#ifdef PEL_TOGETHER
#define meter all_sighted[gl_WorkGroupID.z].meter
#define rod all_sighted[gl_WorkGroupID.z].rod
#define sights all_sighted[gl_WorkGroupID.z].sights
#define out_exposure exposed[gl_WorkGroupID.z].exposure
#define out_exposing exposed[gl_WorkGroupID.z].exposing
#define out_rods exposed[gl_WorkGroupID.z].rods
#define out_glare exposed[gl_WorkGroupID.z].glare
layout(std430, binding = PEL_STORE_EXPOSURE) writeonly buffer out_block {
    pel_shader_exposure exposed[PEL_TOGETHER_MOST];
};
#else
#ifdef PEL_SPACE
layout(location = 0) uniform float form_share; // of the form from high up; 1: all
layout(std430, binding = PEL_STORE_EXPOSURE) buffer out_block {
#else
layout(std430, binding = PEL_STORE_EXPOSURE) writeonly buffer out_block {
#endif
    vec4 out_exposure;
    vec4 out_exposing;
    vec4 out_rods;
    pel_shader_glare out_glare[PEL_GLARES];
};
#endif

shared vec3 partial[PEL_GROUP_LINE];
#ifdef PEL_SPACE
shared pel_shader_glare glare_seen[PEL_LIT];
#endif

float luminance(vec3 light)
{
    float photopic = dot(vec3(0.2126, 0.7152, 0.0722),
                         vec3(dot(red.rgb, light), dot(green.rgb, light), dot(blue.rgb, light)));
    if (rod.w < 0.5) {
        return photopic;
    }
    float scotopic = max(dot(rod.rgb, light), 0.0);
    return mix(scotopic, photopic, eye_cones(photopic, scotopic));
}

#ifndef PEL_SPACE
vec3 mean_sea(vec3 dir)
{
    const vec3 n = vec3(0.0, 0.0, 1.0);
    float range = distance_to_ground(eye.x, dir.z);
    range = range < 0.0 ? sqrt(2.0 * planet.x * eye.x) : range;
    vec2 tilt = dir.xy * (range / planet.x);
    vec3 v = normalize(-vec3(dir.xy - tilt * dir.z, dir.z + dot(tilt, dir.xy)));
    vec3 leaving = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        leaving += leaving_deep_water(i, water_place(v, n, light_above(i, tilt)));
    }
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    leaving *= water_veiled(tilt);
#endif
    lit parts = sea_radiance(reflection_map, v, tilt, n, wind.zw, leaving, vec3(0.0), NOT_PRESSED, 0.0);
    cover_by_foam(vec2(whitecaps.w, 1.0), n, tilt, parts);
    vec3 air;
    vec3 through = haze(dir, range, air);
    return (parts.sun + parts.sky + parts.water) * through + air;
}

#ifdef PEL_UNDER
// How far the lens is in the water.
float wet_lens()
{
    return under_lens.x > 0.5 ? smoothstep(-1.0, 1.0, under_eye.y / PEL_UNDER_DOME) : 1.0;
}
#endif

vec3 seen(vec3 dir)
{
    float angle = angle_above_horizon(dir);
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    vec3 above = normalize(vec3(dir.xy, max(dir.z, 0.0)));
    vec2 place = above.xy / (1.0 + above.z) * (0.5 / PEL_REFLECTION_HALF_WIDTH) + 0.5;
    vec3 light = angle < 0.0 ? mean_sea(dir) : textureLod(reflection_map, place, 0.0).rgb;
#else
    vec3 light = angle < 0.0 ? mean_sea(dir) : sky_light(eye_table, dir.xy, angle);
#endif
#ifdef PEL_UNDER
    float line = under_eye.y / PEL_UNDER_DOME - dir.z + dot(under_eye.zw, dir.xy);
    float wet = under_lens.x > 0.5 ? smoothstep(-0.05, 0.05, line) : 1.0;
    light = mix(light, under_level_seen(reflection_map, dir, under_depth()), wet);
#endif
    return light;
}
#endif

// x the sum of log2 of luminances, y of their fourth powers, z of weights: a
// light and what surrounds it by three degrees may burn out.
vec3 sample_window(int k)
{
    const int each = PEL_METER_COLUMNS * PEL_METER_ROWS;
    pel_shader_sight w = sights[k / each];
    int cell = k % each;
    vec2 place = (vec2(cell % PEL_METER_COLUMNS, cell / PEL_METER_COLUMNS) + 0.5) /
                 vec2(PEL_METER_COLUMNS, PEL_METER_ROWS);
    vec3 dir = normalize(w.right.xyz * mix(w.right.w, w.up.w, place.x) +
                         w.up.xyz * mix(w.back.w, w.below.x, place.y) - w.back.xyz);
    float weight = 1.0;
    for (int i = 0; i < PEL_LIT; i++) {
        weight *= smoothstep(PEL_METER_BLIND_FROM, PEL_METER_BLIND_TO,
                             1.0 - dot(dir, lights[i].direction.xyz));
    }
#ifdef PEL_SPACE
    // By its light, all but, from high up: neither the dark beyond the air nor the
    // night decides for the day beside it, but what the lens scatters does.
    vec3 light = space_seen(reflection_map, transmittance, dir);
    for (int i = 0; i < PEL_LIT; i++) {
        light += space_eye.z * glare_seen[i].light.rgb /
                 (1.0 + (1.0 - dot(dir, glare_seen[i].direction.xyz)) * (2.0 / (PEL_GLARE_CORE * PEL_GLARE_CORE)));
    }
    float bright = max(luminance(light), 1e-6);
    weight *= pow(bright, 0.8 * space_eye.z);
#else
    float bright = max(luminance(seen(dir)), 1e-6);
#endif
    float bright2 = bright * bright;
    return vec3(log2(bright), bright2 * bright2, 1.0) * weight;
}

// Twin of pel_meter_mean, in log2; under water the light on the sea is not the
// light there.
float meter_mean(float mean, float level)
{
    float matt = log2(PEL_METER_MATT * max(level, 1e-6));
    float day = clamp(log2(max(level, 1e-6) / PEL_METER_DULL) / 3.0, 0.0, 1.0);
#ifdef PEL_UNDER
    day *= 1.0 - wet_lens();
#endif
    return mix(mean, matt, PEL_METER_INCIDENT * day);
}

// Twin of pel_meter_ev, of an eye pel_vision_ev.
float meter_ev(float mean, float high, float level)
{
    float key = 1.03 - 2.0 / (2.0 + log2(exp2(mean) + 1.0) * 0.30103);
    key = PEL_METER_KEY * (rod.w < 0.5 ? pow(key, PEL_METER_KEY_POWER)
                                       : key * mix(1.0 - PEL_EYE_FALL, 1.0, sqrt(eye_sight(mean))));
    float adapted = mean - log2(key * (PEL_METER_MIDDLE / PEL_TONE_MIDDLE));
    float kept = high - log2(PEL_METER_HIGH * (PEL_METER_MIDDLE / PEL_TONE_MIDDLE));
    float most = PEL_METER_MOST +
                 PEL_METER_SLOPE * log2(max(level, 1e-6) / PEL_METER_SUNLIGHT);
    return max(min(max(adapted, kept), most),
               rod.w < 0.5 ? PEL_METER_LEAST : PEL_EYE_LEAST);
}

#ifdef PEL_SPACE
// A hood keeps off what shines from beside the picture.
float through_hood(vec3 to)
{
    float most = meter.x < 0.5 ? 1.0 : 0.0;
    for (int k = 0; k < int(meter.x); k++) {
        pel_shader_sight w = sights[k];
        vec3 c = vec3(dot(to, w.right.xyz), dot(to, w.up.xyz), -dot(to, w.back.xyz));
        vec2 at = c.xy / max(c.z, 1e-3);
        vec2 middle = 0.5 * vec2(w.right.w + w.up.w, w.back.w + w.below.x);
        vec2 half_ = 0.5 * abs(vec2(w.up.w - w.right.w, w.back.w - w.below.x));
        vec2 off = abs(at - middle) / half_;
        most = max(most, c.z > 0.0 ? 1.0 - smoothstep(1.0, 2.0, max(off.x, off.y)) : 0.0);
    }
    return mix(1.0, most, space_eye.z);
}
#endif

pel_shader_glare glare_of(int i)
{
    vec4 to = lights[i].direction;
    const float core2 = 0.5 * PEL_GLARE_CORE * PEL_GLARE_CORE;
    // What 1 / (1 + (1 − cos θ) / core2) is times, for its sum over all
    // directions to be 1.
    float centre = 1.0 / (2.0 * PI * core2 * log(1.0 + 2.0 / core2));
#ifdef PEL_SPACE
    vec3 direct;
    space_sight s = sight_of(to.xyz);
    space_air(s, direct);
    direct *= s.disc < 0.0 ? lights[i].irradiance.rgb * through_hood(to.xyz) : vec3(0.0);
#else
    vec3 direct = lights[i].irradiance.rgb *
                  light_transmittance(transmittance, eye.x, to.z, to.w);
#endif
#ifdef PEL_CLOUDS
    direct *= clouds_toward(transmittance, to.xyz, vec3(0.0), vec3(0.0), 0.001, 1e9).beam;
#endif
#ifdef PEL_FOG
    direct *= exp(-fog_to_light(vec3(0.0, 0.0, eye.x), i, to.xyz));
#endif
    float share = meter.w;
#ifdef PEL_UNDER
    share *= 1.0 - wet_lens();
#endif
    return pel_shader_glare(vec4(to.xyz, 0.5 * to.w * to.w), vec4(direct * (share * centre), share));
}

void main()
{
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    veil_lights_evenly();
#endif
#ifdef PEL_UNDER
    veil_water();
#endif
    int lane = int(gl_LocalInvocationID.x);
    int samples = int(meter.x) * PEL_METER_COLUMNS * PEL_METER_ROWS;
    vec3 sum = vec3(0.0);
#ifdef PEL_SPACE
    if (lane < PEL_LIT) {
        glare_seen[lane] = glare_of(lane);
    }
    barrier();
#endif
    for (int k = lane; k < samples; k += PEL_GROUP_LINE) {
        sum += sample_window(k);
    }
    partial[lane] = sum;
    barrier();
    for (int stride = PEL_GROUP_LINE / 2; stride > 0; stride >>= 1) {
        if (lane < stride) {
            partial[lane] += partial[lane + stride];
        }
        barrier();
    }
    if (lane == 0) {
        vec3 all = partial[0] / max(partial[0].z, 1.0);
        float high = 0.25 * log2(max(all.y, 1e-24));
#ifdef PEL_SPACE
        float level_seen = mix(incident.x, max(incident.x, space_sun.w), space_eye.z);
#else
        float level_seen = incident.x;
#endif
        float mean = meter_mean(all.x, level_seen);
        bool fixed_ev = samples == 0 || rod.w > float(PEL_VISION_EYE);
        float ev = fixed_ev ? meter.y : meter_ev(mean, high, level_seen);
#ifdef PEL_SPACE
        if (form_share < 1.0) {
            vec3 low = out_exposure.xyz;
            ev = mix(low.x, ev, form_share);
            all.x = mix(low.y, all.x, form_share);
            high = mix(low.z, high, form_share);
        }
#endif
        out_exposure = vec4(ev, all.x, high, 0.0);
        vec3 balance = meter.z == float(PEL_TONE_LINEAR)
                           ? vec3(1.0)
                           : vec3(PEL_TONE_RED, PEL_TONE_GREEN, PEL_TONE_BLUE);
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
        // Under clouds and in fog white is what a sheet on the sea looks like, as cameras
        // and eyes have it.
        vec3 falling = vec3(0.0);
        for (int i = 0; i < PEL_LIT; i++) {
            falling += beams[i].rgb * (lights_leave[i] * max(lights[i].direction.z, 0.0)) + skies[i].rgb;
        }
        vec3 white = vec3(dot(red.rgb, falling), dot(green.rgb, falling), dot(blue.rgb, falling));
        float grey = dot(vec3(0.2126, 0.7152, 0.0722), white);
        balance = mix(balance, pow(grey / max(white, vec3(1e-9)), vec3(PEL_CLOUD_WHITE)),
                      meter.z == float(PEL_TONE_LINEAR) ? 0.0 : 1.0 - lights_leave[0]);
#endif
#ifdef PEL_SPACE
        if (form_share < 1.0) {
            vec3 low = out_exposing.rgb;
            balance = mix(low / max(low.g, 1e-30) * balance.g, balance, form_share);
        }
#endif
        out_exposing = vec4(balance * (exp2(-ev) * (PEL_TONE_MIDDLE / PEL_METER_MIDDLE)), 0.0);
        out_rods = rod;
        for (int i = 0; i < PEL_LIT; i++) {
            pel_shader_glare glare = glare_of(i);
#ifdef PEL_SPACE
            if (form_share < 1.0) {
                glare.light.rgb = mix(out_glare[i].light.rgb, glare.light.rgb, form_share);
            }
#endif
            out_glare[i] = glare;
        }
    }
}
