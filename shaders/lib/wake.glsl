// Ship waves, twin of ocean/wake.h: displacement and slopes above a place that
// the sea's waves have carried there, from the eye's nadir.
// Includers have lib/spline.glsl.

layout(binding = PEL_UNIT_WAKES) uniform sampler2DArray wake_tiles; // Dx, Dy, h

struct wake_shift {
    vec3 d;
    vec3 dx; // by x
    vec3 dy;
    vec3 lost; // mean squares of slopes that the footprint hides: xx, yy, xy
};

// Mean square slopes of a tile about a place in texels.
vec3 wake_slopes(int i, vec2 at)
{
    vec2 place = at / float(PEL_WAKE_N / PEL_WAKE_ROUGH_N) - 0.5;
    vec2 f = fract(place);
    ivec2 corner = ivec2(floor(place));
    vec3 rows[2];
    for (int b = 0; b < 2; b++) {
        vec3 t[2];
        for (int a = 0; a < 2; a++) {
            ivec2 block = (corner + ivec2(a, b)) & (PEL_WAKE_ROUGH_N - 1);
            t[a] = texelFetch(wake_tiles, ivec3(block, i), PEL_WAKE_ROUGH_LEVEL).xyz;
        }
        rows[b] = mix(t[0], t[1], f.x);
    }
    return mix(rows[0], rows[1], f.y);
}

// What a tile adds, as a footprint sees it: waves of a few texels go first.
void add_wake_tile(int i, vec2 x, float footprint, inout wake_shift sum)
{
    vec4 place = wakes[i].place;
    vec2 from = x - place.xy;
    vec2 u = (abs(from) / place.w - PEL_WAKE_FADE) / (PEL_WAKE_FADED - PEL_WAKE_FADE);
    float shown = 1.0 - smoothstep(1.0, 3.0, footprint * place.z);
    if (max(u.x, u.y) >= 1.0) {
        return;
    }
    vec2 v = clamp(u, 0.0, 1.0);
    vec2 fade = 1.0 - v * v * (3.0 - 2.0 * v);
    vec2 at = x * place.z + wakes[i].offset.xy;
    if (shown < 1.0) {
        float seen = fade.x * fade.y;
        sum.lost += (1.0 - shown * shown) * seen * seen * wake_slopes(i, at);
    }
    if (shown <= 0.0) {
        return;
    }
    vec2 fading = -6.0 * v * (1.0 - v) * sign(from) /
                  ((PEL_WAKE_FADED - PEL_WAKE_FADE) * place.w);
    vec2 f = fract(at);
    ivec2 corner = ivec2(at - f) - 1;
    vec2 w[4];
    vec2 d[4];
    cubic_spline(f, w, d);
    vec3 value = vec3(0.0);
    vec3 by_x = vec3(0.0);
    vec3 by_y = vec3(0.0);
    for (int b = 0; b < 4; b++) {
        for (int a = 0; a < 4; a++) {
            vec3 t = texelFetch(wake_tiles, ivec3((corner + ivec2(a, b)) & (PEL_WAKE_N - 1), i), 0).xyz;
            value += w[a].x * w[b].y * t;
            by_x += d[a].x * w[b].y * t;
            by_y += w[a].x * d[b].y * t;
        }
    }
    float all = shown * fade.x * fade.y;
    sum.d += all * value;
    sum.dx += all * place.z * by_x + shown * fading.x * fade.y * value;
    sum.dy += all * place.z * by_y + shown * fade.x * fading.y * value;
}

// Such slopes along and across the wind.
vec2 wake_variance(vec3 lost)
{
    vec2 d = wind.xy;
    vec2 two = 2.0 * d.x * d.y * vec2(1.0, -1.0);
    return max(lost.x * d * d + lost.y * d.yx * d.yx + lost.z * two, 0.0);
}

// Layers whose tiles may reach a place, as bits.
uint wakes_near(vec2 x)
{
    vec2 place = (x - wake_grid.xy) * wake_grid.zw;
    if (min(place.x, place.y) >= 0.0 && max(place.x, place.y) < float(PEL_WAKE_CELLS)) {
        int cell = int(place.y) * PEL_WAKE_CELLS + int(place.x);
        return uint(wake_cells[cell >> 2][cell & 3]);
    }
    return 0u;
}

wake_shift wake_at(vec2 x, float footprint)
{
    wake_shift sum = wake_shift(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
    for (uint near = wakes_near(x); near != 0u; near &= near - 1u) {
        add_wake_tile(findLSB(near), x, footprint, sum);
    }
    return sum;
}
