// The field of clouds over the plane, twin of optics/clouds.c, and its places.
layout(binding = PEL_UNIT_CLOUDS) uniform sampler2D cloud_field;

// A column of cloud: x its top over the base, in thicknesses, negative beside
// clouds; y the part of the
// place that is below clouds at all.
vec2 cloud_top(vec2 u, float fine)
{
    float s = sqrt(max(u.g - u.r * u.r, 0.0));
    float rise = 1.0 / cloud_shape.y;
    float over = u.r - cloud_shape.x + cloud_light.z * fine * rise;
    // The mean over what the level of detail blurs.
    float x = min((over + 0.8 * s) / (rise + 1.6 * s), 1.0);
    return vec2(x > 0.0 ? x * (2.0 - x) : 2.0 * x, clamp((over + 1.2 * s) / (2.4 * s + 0.03 * rise), 0.0, 1.0));
}

// Of the depth of all air but ozone between the sea and an eye, what is above the
// clouds' middle.
vec3 air_above_clouds(float h)
{
    float z = cloud_size.x + 0.5 * cloud_size.y;
    vec3 molecules = rayleigh.rgb * rayleigh.w;
    float dust = mie.x * mie.z;
    return (molecules * max(exp(-z / rayleigh.w) - exp(-h / rayleigh.w), 0.0) +
            dust * max(exp(-z / mie.z) - exp(-h / mie.z), 0.0)) /
           max(molecules * (1.0 - exp(-h / rayleigh.w)) + dust * (1.0 - exp(-h / mie.z)), vec3(1e-9));
}

// Light of the air between the sea and an eye, of which clouds shade what is below
// them.
vec3 air_below_clouds(float h)
{
    return mix(vec3(cloud_light.x), vec3(1.0), air_above_clouds(h));
}

// Metres as the tile's.
vec2 cloud_across(vec2 x)
{
    vec2 along = vec2(dot(x, eye_clouds.zw), dot(x, vec2(-eye_clouds.w, eye_clouds.z)));
    return along * vec2(cloud_size.z / cloud_size.w, cloud_size.z);
}

// Of metres from the eye's nadir. Waves of many tiles displace the tile, so that it
// is not seen over and over; at the origin by nothing and evenly. They stretch it by
// 0.43 at most.
vec2 cloud_place(vec2 x)
{
    vec2 at = eye_clouds.xy + cloud_across(x);
    vec4 turns = vec4(3.0 * at.x + 5.0 * at.y, 5.0 * at.x - 3.0 * at.y, at.x + at.y, at.x - at.y) / PEL_CLOUD_PERIOD;
    vec4 s = smoothstep(0.0, 0.5, abs(turns - round(turns)));
    return at + 0.2 * s.xy + 0.8 * s.zw;
}

// For the tile of shade, which is not displaced: by as much as what shades a place.
vec2 cloud_shade_place(vec2 x, vec3 to)
{
    vec2 off = to.xy * ((cloud_size.x + 0.35 * cloud_size.y) / max(to.z, 0.05));
    return cloud_place(x + off) - cloud_across(off);
}

float cloud_lod(float metres)
{
    return log2(max(metres * cloud_size.z * float(PEL_CLOUD_TEXELS), 1.0));
}
