// The sea from the cascades' textures, as ocean/cascade.h defines it; x is the
// place at rest from the eye's nadir.

layout(binding = PEL_UNIT_DISPLACEMENT) uniform sampler2DArray displacement_fields; // Dx, Dy, h
layout(binding = PEL_UNIT_SLOPES) uniform sampler2DArray slope_fields; // hx, hy, Dxx, Dyy
layout(binding = PEL_UNIT_FOLD) uniform sampler2DArray fold_field;   // Dxy
#ifdef PEL_FOAM
layout(binding = PEL_UNIT_BREAKING) uniform sampler2DArray breaking_fields; // of ocean/foam.h
#endif

const float COARSEST = float(PEL_CASCADE_LEVELS - 1); // one texel

// Where a cascade is read for a place, and the derivative by that place; from
// one cascade to the next finer one.
struct reading {
    vec2 place;
    vec4 by; // ∂X/∂x, ∂X/∂y, ∂Y/∂x, ∂Y/∂y
};

reading reading_at(vec2 x)
{
    return reading(x, vec4(1.0, 0.0, 0.0, 1.0));
}

// Twin of ocean/shear.h; the constant 1/8 is in the place of the eye's nadir.
void shear(int c, vec2 x, inout reading at)
{
    vec3 shear = cascades[c].shear.xyz;
    vec2 f = shear.xy;
    vec2 r = fract(vec2(dot(x, f), PEL_SHEAR_RATIO * (f.x * x.y - f.y * x.x)) +
                   cascades[c].offset.zw) - 0.5;
    vec2 rest = 1.0 - 2.0 * abs(r);
    vec2 q = r * rest;
    vec2 g = rest + rest - 1.0;
    vec2 v = shear.z * f;
    at.place += q.x * vec2(-v.y, v.x) - (q.y / PEL_SHEAR_RATIO) * v;
    float xx = v.x * f.x;
    float xy = v.x * f.y * (g.x - g.y);
    float yy = v.y * f.y;
    at.by += vec4(-xy, -yy * g.x - xx * g.y, xx * g.x + yy * g.y, xy);
}

#ifdef PEL_SHORE
// The same of a cascade that is a band of the shore's.
reading reading_ashore(int c, vec2 x)
{
    reading at = reading_at(x);
    for (int i = 0; i <= c; i++) {
        shear(i, x, at);
    }
    return at;
}
#endif

vec2 cascade_uv(int c, vec2 place)
{
    vec2 turn = cascades[c].place.xy;
    return vec2(dot(place, turn), dot(place, vec2(-turn.y, turn.x))) * cascades[c].place.z +
           cascades[c].offset.xy;
}

// Cubic B-spline at a level of detail.
#ifdef PEL_HARDWARE
// Samplers in hardware blend with 8 bits of fraction: on the coarsest cascade
// that would move the sea by millimetres from where queries find it.
vec3 spline(int c, vec2 uv, float lod)
{
    int level = int(lod + 0.5);
    int n = PEL_CASCADE_N >> level;
    vec2 at = uv * float(n) - 0.5;
    vec2 f = fract(at);
    ivec2 i = ivec2(at - f) - 1;
    vec2 g = 1.0 - f;
    vec2 w[4] = vec2[4](g * g * g / 6.0, (4.0 - 6.0 * f * f + 3.0 * f * f * f) / 6.0,
                        (4.0 - 6.0 * g * g + 3.0 * g * g * g) / 6.0, f * f * f / 6.0);
    vec3 sum = vec3(0.0);
    for (int b = 0; b < 4; b++) {
        for (int a = 0; a < 4; a++) {
            ivec2 texel = (i + ivec2(a, b)) & (n - 1);
            sum += w[a].x * w[b].y *
                   texelFetch(displacement_fields, ivec3(texel, c), level).xyz;
        }
    }
    return sum;
}
#else
// By four bilinear taps: cheapest where fractions are whole floats.
vec3 spline(int c, vec2 uv, float lod)
{
    float level = floor(lod + 0.5);
    float n = float(PEL_CASCADE_N) * exp2(-level);
    vec2 at = uv * n - 0.5;
    vec2 f = fract(at);
    vec2 i = at - f;
    vec2 f2 = f * f;
    vec2 f3 = f2 * f;
    vec2 w0 = (1.0 - f) * (1.0 - f) * (1.0 - f) / 6.0;
    vec2 w1 = (4.0 - 6.0 * f2 + 3.0 * f3) / 6.0;
    vec2 w3 = f3 / 6.0;
    vec2 w2 = 1.0 - w0 - w1 - w3;
    vec2 g0 = w0 + w1;
    vec2 g1 = w2 + w3;
    vec2 p0 = (i - 0.5 + w1 / g0) / n;
    vec2 p1 = (i + 1.5 + w3 / g1) / n;
    return g0.y * (g0.x * textureLod(displacement_fields, vec3(p0, c), level).xyz +
                   g1.x * textureLod(displacement_fields, vec3(p1.x, p0.y, c), level).xyz) +
           g1.y * (g0.x * textureLod(displacement_fields, vec3(p0.x, p1.y, c), level).xyz +
                   g1.x * textureLod(displacement_fields, vec3(p1, c), level).xyz);
}
#endif

// Displacement at a level of detail. Between two levels it is blended, so that
// nothing pops.
vec3 cascade_displacement(int c, vec2 uv, float lod)
{
    lod = max(lod, 0.0);
    if (lod >= COARSEST) {
        return vec3(0.0);
    }
    float low = floor(lod);
    vec3 finer = spline(c, uv, low);
#ifdef PEL_HARDWARE
    if (lod == low) { // near the eye most cells are finer than a coarse cascade's texels
        return finer;
    }
#endif
    return mix(finer, spline(c, uv, min(low + 1.0, COARSEST)), lod - low);
}

// By the waves that cells of this length carry: half of those as long as the
// middle of the filter's bounds. The longest of a cascade but the first is 6.5
// modes: of four texels there is nothing left.
vec3 cascade_shift(vec2 x, float cell)
{
    vec3 sum = vec3(0.0);
    float finer = back.w - PEL_SHIFT_SHARPER;
    float lod = log2(cell / cascades[0].place.w) + finer;
    reading at = reading_at(x);
    for (int c = 0; c < PEL_CASCADES && lod < (c > 0 ? COARSEST - 2.0 : COARSEST); c++) {
        shear(c, x, at);
        vec2 place = at.place;
#ifdef PEL_SHORE
        shored here = far_out(x);
        if (c < PEL_CASCADES / 2) {
            here = shore_at(c, x);
            place = reading_ashore(c, here.read).place;
        }
#endif
        vec3 shift = cascade_displacement(c, cascade_uv(c, place), lod);
#ifdef PEL_SHORE
        shift *= vec3(here.b, here.b, here.a);
#endif
#ifdef PEL_AREAS
        if (c >= PEL_CASCADES / 2) {
            vec3 washed;
            float up = short_waves(x, cell, washed);
            shift *= vec3(min(vec2(up), 1.0), up);
        }
#endif
        sum += shift;
        lod = log2(cell / cascades[min(c + 1, PEL_CASCADES - 1)].place.w) + finer;
    }
    return sum;
}
