// Glare, the eye's vision, exposure, tone curve, sRGB, dither. Includers have
// lib/ray.glsl.
#include "lib/vision.glsl"

// Twin of pel_tone_curve.
float tone_curve(float x)
{
    float p = pow(x, PEL_TONE_POWER);
    float q = PEL_TONE_STRETCH * p + PEL_TONE_HALF; // f = p / q
    return p * p * (1.0 + PEL_TONE_FLARE) / (q * (p + PEL_TONE_FLARE * q));
}

// By the brightest channel, so that none is cut; the others follow it to white
// only as light becomes many times brighter than the picture: an orange light
// stays orange. Twin of pel_tone_filmic.
vec3 filmic(vec3 x)
{
    float peak = max(max(x.r, x.g), max(x.b, 1e-9));
    float shown = min(tone_curve(peak), 1.0);
    const float PALE2 = PEL_TONE_PALE * PEL_TONE_PALE;
#ifdef PEL_LAMPS
    // However bright, a red light is to be told from a white one.
    const float LEAST = PEL_TONE_LEAST_OF_LAMPS;
#else
    const float LEAST = PEL_TONE_LEAST;
#endif
    float kept = LEAST + (1.0 - LEAST) * PALE2 / (PALE2 + peak * peak);
    return shown + (x - peak) * (shown * kept / peak);
}

// What the lens scatters of the light of small sources (docs/physics/eye.md).
vec3 with_glare(vec3 light, vec3 dir)
{
    const float inverse = 2.0 / (PEL_GLARE_CORE * PEL_GLARE_CORE);
    for (int i = 0; i < PEL_LIT; i++) {
        float away = 1.0 - dot(dir, glare[i].direction.xyz);
        bool source = away < glare[i].direction.w && dir.z > -eye.y;
        light *= source ? 1.0 - glare[i].light.w : 1.0;
        light += glare[i].light.rgb / (1.0 + away * inverse);
    }
    return light;
}

vec3 srgb(vec3 x)
{
    return mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, lessThan(x, vec3(0.0031308)));
}

// A hash of the pixel's place on the lattice, mixed by multiplications and
// shifts until no two places are alike (autocorrelation below 0.02): it dithers,
// and a pattern of it would be a cross-hatch on flat water.
float noise(uvec2 p)
{
    uint x = p.x * 0x9E3779B1u ^ p.y * 0x85EBCA77u;
    x ^= x >> 16u;
    x *= 0x7FEB352Du;
    x ^= x >> 15u;
    x *= 0x846CA68Bu;
    x ^= x >> 16u;
    return float(x >> 8u) / 16777216.0;
}

#ifndef PEL_CAMERAS // of views none of which is an eye's or a sensor's
// What a sensor shows of the eye's colour; p: the place on the lattice.
vec3 sensed(vec3 encoded, uvec2 p)
{
    uvec2 seed = uvec2(sensor_seed.xy);
    bool dropped = noise(uvec2(seed.x, p.y + seed.y)) < sensor_seed.z;
    if (sensor.x == float(PEL_SHADER_SENSOR_OFF) || dropped) {
        return vec3(0.0);
    }
    // Twice: one hash alone shows its lattice.
    uint once = uint(noise(p + seed) * 16777216.0);
    float grain = 2.0 * noise(uvec2(once, once ^ (p.x + (p.y << 16u)))) - 1.0;
    float grey = dot(encoded, vec3(0.2126, 0.7152, 0.0722));
    return vec3(clamp(grey * sensor.y + sensor.z + grain * sensor.w, 0.0, 1.0));
}
#endif

#if defined(PEL_LAMPS) && !defined(PEL_LAMPS_ADDED)
layout(binding = PEL_UNIT_LAMP_LIGHT) uniform sampler2D lamp_light; // of lamps themselves (lamp.frag)
#endif

// Eight-bit colour of a spectral radiance at a pixel.
vec3 display(vec3 light, ivec2 at)
{
#if defined(PEL_LAMPS) && !defined(PEL_LAMPS_ADDED)
    light += texelFetch(lamp_light, at, 0).rgb;
#endif
    vec3 ray = pixel_ray(lattice(at));
    light = with_glare(light, ray / sqrt(dot(ray, ray)));
    vec3 linear = vec3(dot(red.rgb, light), dot(green.rgb, light), dot(blue.rgb, light));
#ifndef PEL_CAMERAS
    if (rods.w > 0.5) {
        linear = eye_seen(linear, dot(rods.rgb, light));
    }
#endif
    linear = clamp(linear * exposing.rgb, 0.0, 1e6);
    vec3 encoded = srgb(sensor_seed.w == float(PEL_TONE_LINEAR) ? min(linear, 1.0) : filmic(linear));
    uvec2 place = uvec2(ivec2(floor(pixel.zw)) + at + 65536);
    float grain = (noise(place) - 0.5) / 255.0;
#ifndef PEL_CAMERAS
    if (sensor.x > 0.5) {
        encoded = sensed(encoded, place);
    }
    // Black is black.
    grain = sensor.x == float(PEL_SHADER_SENSOR_OFF) ? 0.0 : grain;
#endif
    return encoded + grain;
}

// As it lies in memory. What drivers make of other colours in an image may be off
// by one from it: pictures are to be the same whoever writes them.
uint packed_color(vec3 color)
{
    return packUnorm4x8(vec4(color, 1.0));
}
