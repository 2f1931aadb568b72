// A layer of clouds, twin of optics/clouds.c. Includers have lib/sky.glsl.
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
// Twin of pel_cloud_escape.
float cloud_escape(float mu)
{
    return (12.0 + 24.0 * mu) / (14.0 + 21.0 * mu);
}

// Twin of pel_cloud_glow without its beam, for an irradiance of 1.
float cloud_glow(float t, float b, float mu)
{
    const float f = 0.25 / PI;
    float left = exp(-b / mu);
    float d = -f * (3.0 * mu * mu * (1.0 - left) + 2.0 * mu * (1.0 + left)) / (b + 1.33333333);
    float c = f * (3.0 * mu * mu + 2.0 * mu) + 0.66666667 * d;
    float k = cloud_escape(mu);
    float below = 2.0 * PI * max(c + d * b - 3.0 * f * mu * mu * left, 0.0);
    float above = max(mu * (1.0 - left) - below, 1e-6);
    float top = 1.0 + (1.0 - k) * below / above;
    return max(c + d * t - 3.0 * f * mu * mu * exp(-t / mu), 0.0) * mix(top, k, t / max(b, 1e-6));
}
#endif

#ifdef PEL_CLOUDS
#include "lib/cloudfield.glsl"

const float CLOUD_G = PEL_CLOUD_ASYMMETRY;
const int CLOUD_STEPS = 26;
const float CLOUD_WIDE = 13.0; // steps beside clouds through all of the layer

vec2 cloud_column(vec2 at, float lod, float z)
{
    vec2 u = textureLod(cloud_field, at, lod).rg;
    float fine = 0.0;
    // Where it decides, at the rim.
    if (u.r > cloud_shape.x - 0.5 * cloud_light.z / cloud_shape.y) {
        // Whole after PEL_CLOUD_PERIOD tiles.
        fine = textureLod(cloud_field, at * 5.1875 + z * vec2(3e-4, 2e-4), lod + 2.4).b - 0.5;
    }
    return cloud_top(u, fine);
}

// Without its fine structure.
vec2 cloud_bulk(vec2 at, float lod)
{
    return cloud_top(textureLod(cloud_field, at, lod).rg, 0.0);
}

// Depth over the extinction of what is from a top to `m` metres below it.
float cloud_above(float m)
{
    float soft = cloud_shape.w;
    m = max(m, 0.0);
    return m < 0.7 * soft ? m * (0.5 * m / soft + 0.3) : m - 0.245 * soft;
}

// Extinction about a height over the base in a column, as a share of the whole:
// the mean over a step of `dz`.
float cloud_dense(vec2 column, float z, float dz)
{
    float under = column.x * cloud_size.y - z;
    return (cloud_above(under + min(0.5 * dz, z)) - cloud_above(under - 0.5 * dz)) / dz;
}

// What clouds leave of a light's beam at a place of the tile at sea level: the
// mean over `footprint`.
float cloud_lit_at(vec2 at, vec3 to, float footprint)
{
    const int STEPS = 3;
    float up = max(to.z, 0.05);
    float dz = cloud_size.y / float(STEPS);
    float lod = cloud_lod(max(footprint, dz / up * length(to.xy)));
    float depth = 0.0, part = 0.0;
    for (int i = 0; i < STEPS; i++) {
        float z = (float(i) + 0.5) * dz;
        vec2 column = cloud_bulk(at + cloud_across(to.xy * ((cloud_size.x + z) / up)), lod);
        depth += cloud_dense(column, z, dz);
        part = max(part, column.y);
    }
    depth *= cloud_shape.z * dz / up;
    part = max(part, 1e-3);
    return 1.0 - part + part * exp(-min(depth / part, 80.0));
}

// Henyey and Greenstein's.
float cloud_phase(float g, float cosine)
{
    float x = 1.0 + g * g - 2.0 * g * cosine;
    return 0.25 / PI * (1.0 - g * g) / (x * sqrt(x));
}

// Of a beam whose way in the cloud was `way` deep: what one more scattering
// sends on at this angle, less the share 1 - g that goes to all sides. Of n
// scatterings the share g^n has only been turned, by a function whose second
// moment is theirs, g^n: half way (as a power) between all of it and as much as
// puts the beam's own flux through a level slab whose light rises `up`, which
// photons ask for; max(x, 0) = 1/4 + P1/2 + 5/16 P2 - 3/32 P4.
float cloud_forward(float way, float cosine, float up)
{
    const float root = 0.921954; // of g
    float once = exp(-way), never = exp(-CLOUD_G * way);
    float g = root * (exp(-CLOUD_G * (1.0 - root) * way) - never) / max(1.0 - never, 1e-4);
    float u2 = up * up, g2 = g * g;
    float down = 0.25 + 0.5 * g * up + 0.15625 * g2 * (3.0 * u2 - 1.0) -
                 0.01171875 * g2 * g2 * ((35.0 * u2 - 30.0) * u2 + 3.0);
    return once * (cloud_phase(CLOUD_G, cosine) - (1.0 - CLOUD_G) * (0.25 / PI)) +
           CLOUD_G * max(exp(-(1.0 - CLOUD_G) * way) - once, 0.0) * cloud_phase(g, cosine) * sqrt(up / down);
}

// Distance along a ray from height h to where it is as high as z.
float distance_to_height(float h, float mu, float z)
{
    float r = planet.x + h;
    float c = (z - h) * (2.0 * planet.x + h + z);
    float root = sqrt(max(r * r * mu * mu + c, 0.0));
    // Without the difference of large numbers.
    return c < 0.0 ? -r * mu - root : mu >= 0.0 ? c / (r * mu + root) : root - r * mu;
}

#ifdef PEL_STORM
layout(location = PEL_UNIFORM_GLOW_COUNT) uniform int glow_count;
layout(location = PEL_UNIFORM_GLOW_LIGHT) uniform vec3 glow_light;
layout(location = PEL_UNIFORM_GLOWS) uniform vec4 glows[PEL_CLOUD_GLOWS];

// Twin of pel_cloud_within, for all that shines.
vec3 light_within(vec2 x, float z, float high)
{
    float len = 1.0 / ((1.0 - CLOUD_G) * cloud_shape.z);
    float beyond = 0.66666667 * len, period = 2.0 * (high + 2.0 * beyond);
    float sum = 0.0;
    for (int i = 0; i < glow_count; i++) {
        vec2 d = glows[i].xy - x;
        float r2 = dot(d, d) + len * len;
        float up = glows[i].z - cloud_size.x, same = up - z, other = up + z + 2.0 * beyond;
        float near = 0.0, far = 0.0, aside = sqrt(r2);
        if (aside < 0.25 * period) {
            for (float k = -2.0; k <= 2.0; k++) {
                float one = same + k * period, two = other + k * period;
                near += (abs(k) < 2.0 ? 1.0 : 0.5) * inversesqrt(r2 + one * one) -
                        (k < 2.0 ? inversesqrt(r2 + two * two) : 0.0);
            }
        } else {
            for (float n = 1.0; n <= 3.0; n++) {
                float k = 2.0 * PI * n / period, w = k * aside;
                float k0 = sqrt(0.5 * PI / w) * exp(-w) * (1.0 - 0.125 / w + 0.0703125 / (w * w));
                far += (cos(k * same) - cos(k * other)) * k0;
            }
            far *= 4.0 / period;
        }
        sum += glows[i].w * max(near + far, 0.0);
    }
    return glow_light * (sum * 0.75 / (PI * len));
}
#endif

struct clouded {
    vec3 light;   // of the clouds, and of the air before them
    float beam;   // what comes through of a beam
    float before; // what comes through of the light of a wide sky behind
    vec3 air;     // of it, the air before the clouds
};

// What a clear sky lets through.
vec3 through_sky(sampler2D transmittance, vec3 dir)
{
    return transmittance_to_top(transmittance, eye.x, max(dir.z, horizon_cosine(eye.x)));
}

// Towards a unit direction: `sky` is the clear air's radiance there and `all` what
// it lets through, `angle` that of a pixel, `far` where what is seen stands.
clouded clouds_toward(sampler2D transmittance, vec3 dir, vec3 sky, vec3 all, float angle, float far)
{
    float h = eye.x;
    float low = cloud_size.x, high = low + cloud_size.y;
    float from = h < low ? distance_to_height(h, dir.z, low) : h > high ? distance_to_height(h, dir.z, high) : 0.0;
    float to_ = dir.z > 0.0 || h <= low ? distance_to_height(h, dir.z, high) : distance_to_height(h, dir.z, low);
    to_ = min(min(to_, far), from + 40.0 * cloud_size.y);
    clouded result = clouded(vec3(0.0), 1.0, 1.0, vec3(0.0));
    if (from >= far || to_ <= from) {
        return result;
    }
    float wide_step = (to_ - from) / CLOUD_WIDE;
    float fine_step = min(wide_step, 1.0 / cloud_shape.z);
    float tau = 0.0;         // on the way so far
    float mean = 0.0;        // of the distance
    vec3 sum = vec3(0.0);
    vec3 below = vec3(0.0), sky_up = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        sky_up += skies[i].rgb * (1.0 / PI);
        below += (beams[i].rgb * max(lights[i].direction.z, 0.0) + skies[i].rgb) * (0.06 / PI) * cloud_light.x;
    }
    vec2 turn = dir.xy * (from + 0.5 * (to_ - from)) / planet.x;
    vec3 to[PEL_LIT], beam[PEL_LIT];
    float cosine[PEL_LIT];
    for (int i = 0; i < PEL_LIT; i++) {
        to[i] = light_above(i, turn);
        beam[i] = lights[i].irradiance.rgb *
                  light_transmittance(transmittance, 0.5 * (low + high), to[i].z, lights[i].direction.w);
        cosine[i] = dot(dir, lights[i].direction.xyz);
    }
    float blur = 0.5 * (from + to_) * angle, level = length(dir.xy);
    float leaves = cloud_escape(abs(dir.z));
    vec3 source = vec3(0.0), single = vec3(0.0);
    float lit_at = -1e9, lit_tau = 0.0;
    float t0 = from, length_ = wide_step;
    // m below the top, at t0.
    float start = height_along(h, dir.z, from) - low;
    float inside = cloud_column(cloud_place(dir.xy * from), cloud_lod(max(0.9 * fine_step * level, 1.5 * blur)), start).x *
                       cloud_size.y - start;
    length_ = inside > 0.0 ? fine_step : wide_step;
    for (int k = 0; k < CLOUD_STEPS && tau < 40.0 && t0 < to_; k++) {
        // The last step takes the mean of what is left of the way.
        bool rest = k == CLOUD_STEPS - 1;
        float t1 = rest ? to_ : min(t0 + length_, to_);
        length_ = t1 - t0;
        float z1 = height_along(h, dir.z, t1) - low;
        float lod = cloud_lod(max(0.9 * length_ * level, 1.5 * blur));
        vec2 here = cloud_column(cloud_place(dir.xy * (rest ? 0.5 * (t0 + t1) : t1)), lod, z1);
        float last = inside;
        // Between two heights of steps the top is a straight line.
        inside = here.x * cloud_size.y - z1;
        if (!rest && last <= 0.0 && inside > 0.0 && length_ > 1.5 * fine_step) {
            // Once more from where it begins, in fine steps.
            t0 = max(t1 - length_ * inside / (inside - last) - 0.5 * fine_step, t0);
            inside = -1e-3;
            length_ = fine_step;
            continue;
        }
        t0 = t1;
        float done = length_;
        // Beside a cloud as far as it may be away, and as far as the steps
        // that are left ask for.
        length_ = max(clamp(inside > 0.0 ? length_ * 1.35 : -0.5 * inside, max(fine_step, 0.2 * wide_step), wide_step),
                      inside > 0.0 ? 0.0 : (to_ - t1) / max(float(CLOUD_STEPS - 3 - k), 1.0));
        float most = here.x * cloud_size.y;
        if (rest) {
            // Half in and half out, where the field varies.
            inside = max(inside, 0.25 * most);
            last = max(last, 0.25 * most);
        }
        if (max(inside, last) <= 0.0) {
            continue;
        }
        float span = abs(inside - last);
        float share = min(inside, last) >= 0.0 ? 1.0 : max(inside, last) / span;
        float middle = min(inside, last) >= 0.0 ? 0.5 * (inside + last) : 0.5 * max(inside, last);
        float dense = share * here.y * clamp(middle / cloud_shape.w + 0.3, 0.0, 1.0) * cloud_shape.z;
        // The middle of what is inside.
        float t = t1 - (last < inside ? 0.5 * share : 1.0 - 0.5 * share) * done;
        float z = height_along(h, dir.z, t) - low;
        vec2 column = vec2((z + middle) / cloud_size.y, 1.0);
        float next = tau + dense * done;
        // Light changes more slowly than the cloud.
        if (t - lit_at > wide_step || tau - lit_tau > 1.5) {
            lit_at = t;
            lit_tau = tau;
            // In the middle of where it serves.
            float serves = max(0.5 * (min(1.5 / cloud_shape.z, wide_step) - share * done), 0.0);
            float mid = min(t + serves, to_), zm = height_along(h, dir.z, mid) - low;
            float whole = cloud_above(column.x * cloud_size.y) * cloud_shape.z;
            float above = min(cloud_above(column.x * cloud_size.y - zm) * cloud_shape.z, whole);
            float scaled = (1.0 - CLOUD_G) * whole;
            float depth = (1.0 - CLOUD_G) * above;
            float inverse = 1.0 / (scaled + 1.33333333);
            source = sky_up * ((scaled - depth + 0.66666667) * inverse) +
                          below * ((depth + 0.66666667) * inverse);
#ifdef PEL_STORM
            source += light_within(dir.xy * mid, zm, cloud_size.y);
#endif
            single = vec3(0.0);
            for (int i = 0; i < PEL_LIT; i++) {
                float up = max(to[i].z, 0.02);
                // On the way to the light, to the layer's top: in what is
                // beyond six times its thickness as before it.
                float reach = 0.0, way = 0.0, all = max(cloud_size.y - zm, 0.05 * cloud_size.y) / up;
                float seen = min(all, 6.0 * cloud_size.y);
                for (int j = 0; j < 3; j++) {
                    float part = seen * (j == 0 ? 0.1 : j == 1 ? 0.3 : 0.6);
                    vec3 off = to[i] * (reach + 0.5 * part);
                    vec2 there = cloud_bulk(cloud_place(dir.xy * mid + off.xy), max(lod + float(j), cloud_lod(0.5 * part * length(to[i].xy))));
                    way += part * cloud_dense(there, zm + off.z, part * to[i].z);
                    reach += part;
                }
                way *= cloud_shape.z * all / seen;
                // What is more than its own column has is other clouds' shadow.
                float t_light = min(way * up, whole);
                float shade = exp(-(1.0 - CLOUD_G) * (way - t_light / up));
                float t_scaled = (1.0 - CLOUD_G) * t_light;
                source += beam[i] * (shade * (cloud_glow(t_scaled, scaled, up) + exp(-t_scaled / up) * (0.25 / PI)));
                single += beam[i] * cloud_forward(way, cosine[i], up);
            }
        }
        float s0 = exp(-(1.0 - CLOUD_G) * tau), s1 = exp(-(1.0 - CLOUD_G) * next);
        sum += source * (leaves * (s0 - s1)) + single * (exp(-tau) - exp(-next));
        mean += t * (s0 - s1);
        tau = next;
    }
    float wide = exp(-(1.0 - CLOUD_G) * tau);
    result.beam = exp(-tau);
    result.before = wide;
    if (wide < 1.0) {
        // The air before them: its part of the sky's by its own optical depth.
        float d = mean / (1.0 - wide);
        float rise = height_along(h, dir.z, d) - h;
        rise = rise < 0.0 && h > high ? min(rise, -1.0) : max(rise, 1.0);
        float r = rayleigh.w, m = mie.z;
        vec3 way = d / rise *
                   (rayleigh.rgb * r * (exp(-h / r) - exp(-(h + rise) / r)) +
                    mie.x * m * (exp(-h / m) - exp(-(h + rise) / m)));
        vec3 through = exp(-way);
        result.air = sky * clamp((1.0 - through) / max(1.0 - all, 1e-4), 0.0, 1.0);
        // Clouds that are seen from above leave it its light.
        result.light = sum * through + result.air * (1.0 - wide) * (h > high ? 1.0 : cloud_light.x);
    }
    return result;
}

// Of `before`, what comes through of a beam.
float beam_behind_clouds(float before)
{
    return pow(before, 1.0 / (1.0 - CLOUD_G));
}

// The sky with its clouds: what is before them is in the light of what they let
// through.
vec3 clouded_sky(clouded c, vec3 sky)
{
    float lit_ = eye.x > cloud_size.x + cloud_size.y ? 1.0 : mix(cloud_light.x, 1.0, c.before);
    return c.light + (sky - c.air) * c.before + c.air * c.before * lit_;
}
#endif
