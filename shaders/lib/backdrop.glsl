// What is not sea: the sky and the Sun's disc.

layout(binding = PEL_UNIT_TRANSMITTANCE) uniform sampler2D transmittance;

shaded shade_backdrop(ivec2 at)
{
    vec3 ray = pixel_ray(lattice(at));
    float inverse = inversesqrt(dot(ray, ray));
    vec3 dir = ray * inverse;
    float angle = max(angle_above_horizon(dir), 0.0);
    vec2 table = vec2(textureSize(eye_table, 0));
    vec3 disc = vec3(0.0);
    vec3 light = textureLod(eye_table, sky_uv(azimuth_from_sun(dir.xy), angle, table), 0.0).rgb;
#ifndef PEL_NO_DISC
    // The disc, its edge softened over a pixel, darkened towards the limb
    // (Hestroffer and Magnan 1998 at the mean wavelength).
    vec3 across = cross(dir, sun.xyz);
    float off = sqrt(dot(across, across));
    float blur = pixel.x * inverse;
    if (dot(dir, sun.xyz) > 0.0 && off < sun.w + blur) {
        float cover = 1.0 - smoothstep(sun.w - 0.5 * blur, sun.w + 0.5 * blur, off);
        float inside = min(off / sun.w, 1.0);
        vec3 limb = pow(vec3(max(1.0 - inside * inside, 1e-4)), 0.5 * vec3(0.43, 0.5, 0.6));
        vec3 norm = 1.0 + 0.5 * vec3(0.43, 0.5, 0.6);
        disc = solar.rgb / solar.w * limb * norm * cover *
                 transmittance_to_top(transmittance, eye.x, max(dir.z, horizon_cosine(eye.x)));
    }
#endif
    shaded result;
    result.radiance = from_under_water(light + disc, dir.z);
#ifdef PEL_LAYERS
    result.depth = uintBitsToFloat(0x7F800000u); // no surface: infinity
    result.normal = vec4(0.0);
    result.sun = lut.y > 0.5 ? vec3(0.0) : disc;
    result.sky = lut.y > 0.5 ? vec3(0.0) : light;
    result.water = lut.y > 0.5 ? result.radiance : vec3(0.0);
    result.air = vec3(0.0);
    result.variance = vec2(0.0);
#endif
#ifdef PEL_WATER_PARTS
    result.parts = water_from_below(lut.y > 0.5 ? result.radiance : vec3(0.0));
#endif
    return result;
}
