// Fog and haze in layers and banks, twin of optics/fog.c. Includers have
// lib/clouds.glsl.
#ifdef PEL_FOG
#ifndef PEL_FOG_LAYERS
#define PEL_FOG_LAYERS 1
#define PEL_FOG_BANKS 0
#define PEL_FOG_LIFTED false
#endif
float fog_ramp(float x)
{
    return clamp(x, 0.0, 1.0);
}

float fog_ramped(float x)
{
    return x < 1.0 ? 0.5 * fog_ramp(x) * fog_ramp(x) : x - 0.5;
}

// What of a layer is above a height, over its extinction; `base`: it does not
// stand on the sea.
float layer_above(vec4 shape, bool base, float z)
{
    float above = fog_ramped((shape.y - z) / shape.w + 0.5);
    return shape.w * (base ? above - fog_ramped((shape.x - z) / shape.w + 0.5) : above);
}

float layer_density(vec4 shape, bool base, float z)
{
    float below = fog_ramp((shape.y - z) / shape.w + 0.5);
    return base ? below - fog_ramp((shape.x - z) / shape.w + 0.5) : below;
}

// Of light that is emitted evenly over an optical depth: its mean place.
float emitted_at(float tau)
{
    return tau < 0.02 ? 0.5 - tau / 12.0 : 1.0 / tau - 1.0 / (exp(min(tau, 80.0)) - 1.0);
}

vec2 fog_crossings(float h, float mu, float z)
{
    float b = (planet.x + h) * mu;
    float c = (z - h) * (2.0 * planet.x + h + z);
    float root = sqrt(max(b * b + c, 0.0));
    float q = b > 0.0 ? -b - root : -b + root;
    float other = abs(q) > 0.0 ? -c / q : 0.0;
    return b * b + c > 0.0 ? vec2(min(q, other), max(q, other)) : vec2(-b);
}

// Optical depth of a piece between two heights.
float layer_piece(vec4 shape, bool base, float length_, float z0, float z1)
{
    float dz = z1 - z0;
    float mean = abs(dz) < 0.05 ? layer_density(shape, base, 0.5 * (z0 + z1))
                                : (layer_above(shape, base, z0) - layer_above(shape, base, z1)) / dz;
    return shape.z * length_ * mean;
}

// x the optical depth of a layer on the sea, y whence the light comes that it
// scatters; `end`: height where the way ends.
vec2 low_way(vec4 shape, float h, float mu, float range, float end)
{
    float top = shape.y + 0.5 * shape.w;
    vec2 high = fog_crossings(h, mu, top);
    float from = clamp(high.x, 0.0, range);
    float to = clamp(high.y, from, range);
    float lowest = clamp(-(planet.x + h) * mu, from, to), z = height_along(h, mu, lowest);
    float tau = layer_piece(shape, false, lowest - from, from > 0.0 ? top : h, z) +
                layer_piece(shape, false, to - lowest, z, to < range ? top : end);
    return vec2(tau, from + (to - from) * emitted_at(tau));
}

// The same of one above it: down into it, and up out of it again.
vec2 lifted_way(vec4 shape, float h, float mu, float range)
{
    vec2 high = fog_crossings(h, mu, shape.y + 0.5 * shape.w);
    vec2 low = fog_crossings(h, mu, shape.x - 0.5 * shape.w);
    float from = clamp(high.x, 0.0, range);
    float to = clamp(high.y, from, range);
    float down = clamp(low.x, from, to);
    float up = clamp(low.y, down, to);
    float first = layer_piece(shape, true, down - from, height_along(h, mu, from), height_along(h, mu, down));
    float second = layer_piece(shape, true, to - up, height_along(h, mu, up), height_along(h, mu, to));
    float one = 1.0 - exp(-first), two = exp(-first) * (1.0 - exp(-second));
    float near = from + (down - from) * emitted_at(first);
    float far = up + (to - up) * emitted_at(second);
    return vec2(first + second, (one * near + two * far) / max(one + two, 1e-30));
}

// The integral of (c - q)⁺, q = least + a v².
float fog_inside(float c, float least, float a, float from, float to)
{
    float w = sqrt(max(c - least, 0.0) / a);
    float v0 = max(from, -w), v1 = min(to, w);
    return v1 > v0 ? (c - least) * (v1 - v0) - a / 3.0 * (v1 * v1 * v1 - v0 * v0 * v0) : 0.0;
}

float bank_part(float extinction, float least, float a, float from, float to)
{
    return extinction / PEL_FOG_RIM *
           (fog_inside(1.0, least, a, from, to) - fog_inside(1.0 - PEL_FOG_RIM, least, a, from, to));
}

vec2 bank_way(pel_shader_fog f, vec3 at, vec3 dir, float range)
{
    vec2 x = at.xy - f.place.xy;
    float wide = f.place.z, tall = f.shape.y * f.shape.y;
    float level = dot(dir.xy, dir.xy);
    float near = clamp(-dot(x, dir.xy) / max(level, 1e-12), 0.0, range);
    float bend = 0.5 * level / planet.x;
    float z = height_along(at.z, dir.z, near) - f.shape.x;
    float rise = dir.z + 2.0 * bend * near;
    x += near * dir.xy;
    float a = max(level * wide + (rise * rise + 2.0 * z * bend) * tall, 1e-12);
    float b = dot(x, dir.xy) * wide + rise * z * tall;
    float least = dot(x, x) * wide + z * z * tall - b * b / a;
    float from = b / a - near, to = from + range;
    float tau = bank_part(f.shape.z, least, a, from, to);
    float w = sqrt(max(1.0 - least, 0.0) / a);
    float v0 = clamp(-w, from, to), v1 = clamp(w, from, to);
    return vec2(tau, v0 - from + (v1 - v0) * emitted_at(tau));
}

// Kinds of fog stand one after the other: layers, then banks. Their numbers are
// the program's: the software device reads what a number says that it knows
// twenty times faster.

// Of all layers: optical depth of what is above a height; yz on the way to the
// lights.
vec3 layers_above(float z)
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < PEL_FOG_LAYERS; i++) {
        sum += fogs[i].shape.z * layer_above(fogs[i].shape, PEL_FOG_LIFTED, z) * vec3(1.0, fogs[i].place.xy);
    }
    return sum;
}

// Optical depth of what of banks is above, x, and below a place.
vec2 banks_column(vec3 at)
{
    vec2 sum = vec2(0.0);
    for (int i = PEL_FOG_LAYERS; i < PEL_FOG_LAYERS + PEL_FOG_BANKS; i++) {
        vec4 shape = fogs[i].shape;
        vec2 x = at.xy - fogs[i].place.xy;
        float z = at.z - shape.x, far = 2.0 / shape.y;
        float least = dot(x, x) * fogs[i].place.z, a = shape.y * shape.y;
        sum += vec2(bank_part(shape.z, least, a, z, max(far, z)),
                    bank_part(shape.z, least, a, max(-shape.x, -far), z));
    }
    return sum;
}

// Optical depth towards a light.
float fog_to_light(vec3 at, int light, vec3 to)
{
    vec3 layers = layers_above(at.z);
    float sum = light == 0 ? layers.y : layers.z;
    for (int i = PEL_FOG_LAYERS; i < PEL_FOG_LAYERS + PEL_FOG_BANKS; i++) {
        sum += bank_way(fogs[i], at, to, 1e6).x;
    }
    return sum;
}

float fog_phase(float g, float cosine)
{
    float x = inversesqrt(1.0 + g * g - 2.0 * g * cosine);
    return 0.25 / PI * (1.0 - g * g) * (x * x * x);
}

// Twin of pel_fog_source but for what was scattered once.
vec3 fog_source(vec3 at, vec3 dir, out vec3 single)
{
    const float G = PEL_CLOUD_ASYMMETRY, FAR = 1.0 - G;
    vec2 banks = banks_column(at);
    float above = layers_above(at.z).x + banks.x;
    float all = FAR * (fog_layers.x + banks.x + banks.y);
    float t = FAR * above;
    float inverse = 1.0 / (all + 1.33333333);
    vec3 level = open_sky.rgb;
    vec3 sum = vec3(0.0);
    single = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        vec3 to = lights[i].direction.xyz;
        vec3 beam = beams[i].rgb;
#ifdef PEL_CLOUDS
        beam *= cloud_light.y;
#endif
        level += beam * max(to.z, 0.0);
        float mu = max(to.z, 0.02), cosine = dot(dir, to);
        float way = min(fog_to_light(at, i, to), 80.0);
        float lit = min(FAR * way * mu, all), once = exp(-way);
        float turned = max(exp(-lit / mu) - once, 0.0);
        single += beam * (fog_phase(G, cosine) * once);
        sum += beam * (cloud_glow(lit, all, mu) + turned * fog_phase(exp2(log2(G) * (1.0 + way)), cosine));
    }
    vec3 sea = level * (0.06 * 1.33333333 * inverse);
    return sum + (open_sky.rgb * (all - t + 0.66666667) + sea * (t + 0.66666667)) * (inverse / PI);
}

struct fogged {
    float tau;   // optical depth
    float mean;  // m, whence its light comes
    vec3 source; // that light's, but for
    vec3 single; // what was scattered once
};

// Adds a part, whose light comes from so far.
void fog_add(vec3 at, vec3 dir, float mean, float part, inout fogged f, inout float all)
{
    vec3 single;
    vec3 place = vec3(at.xy + mean * dir.xy, height_along(at.z, dir.z, mean));
    vec3 source = fog_source(place, dir, single);
    f.source += part * source;
    f.single += part * single;
    f.mean += part * mean;
    all += part;
}

// Layers as one, and each bank: its part of the light that reaches the eye, by
// which of the two stands nearer.
fogged fog_toward(vec3 at, vec3 dir, float range)
{
    float end = height_along(at.z, dir.z, range);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < PEL_FOG_LAYERS; i++) {
        vec2 way = PEL_FOG_LIFTED ? lifted_way(fogs[i].shape, at.z, dir.z, range)
                                  : low_way(fogs[i].shape, at.z, dir.z, range, end);
        sum += vec3(way, 1.0) * vec3(1.0, vec2(way.x));
    }
    float mean = sum.y / max(sum.z, 1e-30);
    fogged f = fogged(sum.x, 0.0, vec3(0.0), vec3(0.0));
    float all = 0.0, nearer = 0.0;
    for (int i = PEL_FOG_LAYERS; i < PEL_FOG_LAYERS + PEL_FOG_BANKS; i++) {
        vec2 way = bank_way(fogs[i], at, dir, range);
        f.tau += way.x;
        nearer += way.y < mean ? way.x : 0.0;
        float part = (mean < way.y ? exp(-sum.x) : 1.0) * (1.0 - exp(-way.x));
        fog_add(at, dir, way.y, part, f, all);
    }
#if PEL_FOG_LAYERS > 0
    fog_add(at, dir, mean, exp(-nearer) * (1.0 - exp(-sum.x)), f, all);
#endif
    float inverse = 1.0 / max(all, 1e-20);
    f.mean *= inverse;
    f.source *= inverse;
    f.single *= inverse;
    return f;
}

// Of a wide sky what is turned a little still comes: it fades by the similar
// optical depth. `light` is also what the air before the fog tends to.
vec3 foggy_sky(fogged f, vec3 light)
{
    float wide = exp(-(1.0 - PEL_CLOUD_ASYMMETRY) * f.tau);
    vec3 before = exp(-(rayleigh.rgb + mie.x) * f.mean);
    return light * wide + (light * (1.0 - before) + f.source * before) * (1.0 - wide) +
           f.single * before * (1.0 - exp(-f.tau));
}
#endif
