// The ray of a pixel, not normalised: its length along the axis is 1. Exactly
// the same for the same place of the lattice, whatever picture it belongs to.
vec2 lattice(ivec2 at)
{
    return pixel.zw + vec2(at) + 0.5;
}

vec3 pixel_ray(vec2 place)
{
    return right.xyz * (place.x * pixel.x) - up.xyz * (place.y * pixel.y) - back.xyz;
}

// Angle above the horizon of the eye for a unit direction.
float angle_above_horizon(vec3 dir)
{
    float z = dir.z;
    float z2 = z * z;
    float elevation = abs(z) < 0.3 ? z * (1.0 + z2 * (1.0 / 6.0 + z2 * (3.0 / 40.0)))
                                   : 0.5 * PI - fast_acos(z);
    return elevation + eye.y;
}
