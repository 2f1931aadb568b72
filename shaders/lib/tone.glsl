// Exposure, tone curve, sRGB, dither.

// Saturation-based exposure (ISO 12232) puts 1.2 · 2^EV cd/m² at 1; KEY opens
// it for the curve x (a x + b) / (x (c x + d) + e), which has a toe, a nearly
// straight middle and a long shoulder.
const float KEY = 2.8;
// The camera's white balance: daylight of a clear day, Sun at 35°, is grey.
// From optics/atmosphere.c: its irradiance is Rec. 709 (1.187, 1, 0.900).
const vec3 DAYLIGHT = vec3(0.870, 1.0325, 1.147);

vec3 tone_curve(vec3 x)
{
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

vec3 srgb(vec3 x)
{
    return mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, lessThan(x, vec3(0.0031308)));
}

// A hash of the pixel's place on the lattice (Jarzynski and Olano 2020).
float noise(uvec2 p)
{
    uint x = p.x * 1664525u + 1013904223u;
    uint y = p.y * 1664525u + 1013904223u;
    x += y * 1664525u;
    y += x * 1664525u;
    x ^= x >> 16u;
    x += y * 1664525u;
    return float(x >> 8u) / 16777216.0;
}

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

// Eight-bit colour of a spectral radiance at a pixel.
vec3 display(vec3 light, ivec2 at)
{
    float ev = size.w > 0.5 ? exposure.x : size.z;
    float scale = 1.0 / (1.2 * exp2(ev));
    vec3 linear = max(vec3(dot(red.rgb, light), dot(green.rgb, light), dot(blue.rgb, light)), 0.0);
    linear = min(linear * DAYLIGHT * (scale * KEY), 1e4);
    // A little of the luminance in every channel, so that glare runs to white.
    linear = mix(linear, vec3(dot(linear, vec3(0.2126, 0.7152, 0.0722))), 0.08);
    vec3 encoded = srgb(clamp(tone_curve(linear), 0.0, 1.0));
    uvec2 place = uvec2(ivec2(floor(pixel.zw)) + at + 65536);
    if (sensor.x > 0.5) {
        encoded = sensed(encoded, place);
    }
    // Black is black.
    return encoded + (sensor.x == float(PEL_SHADER_SENSOR_OFF) ? 0.0 : (noise(place) - 0.5) / 255.0);
}
