// Clouds from high up: a matt layer of the depth that their field has below a
// sight. Where many tiles of the field are in sight, systems of clouds on the Earth
// take over which of its places have some.
#include "lib/cloudfield.glsl"

// Three values of a smooth noise over the lattice, of mean 1/2.
vec3 noise_at(vec3 p)
{
    vec3 cell = floor(p), f = p - cell;
    f = f * f * (3.0 - 2.0 * f);
    uvec3 c = uvec3(ivec3(cell) + 4096);
    vec3 sum = vec3(0.0);
    for (uint k = 0u; k < 8u; k++) {
        uvec3 off = uvec3(k & 1u, k >> 1u & 1u, k >> 2u);
        vec3 w = mix(1.0 - f, f, vec3(off));
        sum += vec3(glint_hash(c + off) >> 8u) * (w.x * w.y * w.z / 16777216.0);
    }
    return sum;
}

// A normal number of variance 1 made of waves of 2,600 km and shorter, without those
// that a footprint blurs; y: their variance. About the scene's origin each wave
// begins with nothing, so that the scene has the cover that it asks for.
vec2 cloud_systems(vec3 earth, float footprint)
{
    const float OF_NOISE = 5.4; // 1 over its deviation
    const float FIRST = 0.7, EACH = 0.85, ALL = 2.9; // weights, the sum of their squares
    vec3 away = (earth - space_origin.xyz) * 2.4;
    float near = 2.0 * dot(away, away); // squares of 0.7 wavelengths
    vec3 p = earth * vec3(2.4, 2.4, 3.4) + space_cloud.x;
    vec3 warp = noise_at(p) - 0.5;
    float sum = FIRST * (warp.x - space_origin.w * exp(-near)), weight = 1.0, left = ALL - FIRST * FIRST;
    float metres = planet.x / 2.4;
    p += 0.9 * warp.yzx;
    for (int i = 0; i < 8 && footprint < 0.5 * metres; i++) {
        p = 2.2 * vec3(0.8 * p.x - 0.6 * p.y, 0.6 * p.x + 0.8 * p.y, p.z) + 17.3;
        metres /= 2.2;
        near *= 2.2 * 2.2;
        weight *= EACH;
        sum += weight * (noise_at(p).x - 0.5 - space_systems[i / 4][i % 4] * exp(-near));
        left -= weight * weight;
    }
    return vec2(sum * (OF_NOISE * inversesqrt(ALL)), max(left, 0.0) / ALL);
}

// The field's rank at a place x on the map and its square, as a footprint has them;
// `systems` there.
vec2 cloud_ranks(vec2 x, float footprint, vec2 systems)
{
    vec2 u = textureLod(cloud_field, cloud_place(x), cloud_lod(footprint)).rg;
    if (space_cloud.y > 0.0) {
        float blur = sqrt(max(u.g - u.r * u.r, 0.0));
        // Its tile would be seen over and over where it is a few dozen pixels.
        float share = mix(space_cloud.y, 0.98, smoothstep(0.002, 0.015, footprint * cloud_size.z) *
                                                   min(3.0 * space_cloud.y, 1.0));
        // Ranks as normal numbers, mixed, and back.
        float rank = clamp(u.r, 0.002, 0.998);
        float own = log(rank / (1.0 - rank)) / 1.702;
        float z = sqrt(1.0 - share) * own + sqrt(share) * systems.x;
        blur = sqrt((1.0 - share) * 12.0 * blur * blur + share * systems.y) * 0.4 * exp(-0.5 * z * z);
        u.r = 1.0 / (1.0 + exp(-1.702 * z));
        u.g = u.r * u.r + blur * blur;
    }
    return u;
}

struct space_layer {
    vec4 seen;         // light that the layer adds; what is seen of what lies below it
    float beam, light; // what the sea there has of the first light's beam, and in all
};

// Optical depth of a column, without what is only turned.
float cloud_depth(vec2 column)
{
    return (1.0 - PEL_CLOUD_ASYMMETRY) * cloud_shape.z * cloud_size.y * max(column.x, 0.02);
}

// Eddington's slab without absorption, over a dark sea.
float through_slab(float depth, float mu)
{
    return (2.0 / 3.0 + mu + (2.0 / 3.0 - mu) * exp(-depth / mu)) / (4.0 / 3.0 + depth);
}

space_layer space_clouds(space_point p, vec3 v, float footprint)
{
    float high = cloud_size.x + 0.5 * cloud_size.y;
    vec2 systems = vec2(0.0);
    if (space_cloud.y > 0.0) {
        systems = cloud_systems(p.earth, footprint);
    }
    // Slanting sights meet clouds' sides, too, where these are seen at all.
    vec2 slant = v.xy / max(v.z, 0.05);
    int steps = footprint < 2.0 * cloud_size.y * length(slant) ? 4 : 1;
    vec2 column = vec2(-1.0, 0.0);
    float part = 0.0;
    for (int k = 0; k < steps; k++) {
        float z = steps == 1 ? 0.5 : 0.3 * float(k); // of its thickness
        vec2 one = cloud_top(cloud_ranks(p.x + slant * (cloud_size.x + z * cloud_size.y), footprint, systems), 0.0);
        float met = k == 0 ? one.y : one.y * clamp((one.x - z) * 4.0 + 0.5, 0.0, 1.0);
        column = met > part ? one : column;
        part = max(part, met);
    }
    float depth = cloud_depth(column);
    vec3 sum = vec3(0.0);
    space_layer layer;
    for (int i = 0; i < PEL_LIT; i++) {
        float mu = max(space_to[i].z, 0.02);
        float of_sky = depth / (4.0 / 3.0 + depth);
        sum += beam_there(i) * max(space_to[i].z, 0.0) * (1.0 - through_slab(depth, mu)) + skies[i].rgb * of_sky;
    }
    // Shadows on the sea, blurred by what of the layer a beam goes through.
    vec3 to = space_to[PEL_LIGHT_FIRST];
    float up_ = max(to.z, 0.05);
    vec2 off = to.xy / up_;
    vec2 above = cloud_top(cloud_ranks(p.x + off * high, max(footprint, cloud_size.y * length(off)), systems), 0.0);
    float dark = cloud_depth(above);
    layer.beam = 1.0 - above.y * (1.0 - exp(-dark / ((1.0 - PEL_CLOUD_ASYMMETRY) * up_)));
    layer.light = 1.0 - above.y * (1.0 - through_slab(dark, up_));
    // Thick clouds fade towards the limb.
    float escapes = (12.0 + 24.0 * v.z) / (14.0 + 21.0 * v.z);
    layer.seen = vec4(sum * (part * escapes / PI), 1.0 - part * (1.0 - exp(-depth / max(v.z, 0.1)) ));
    return layer;
}
