// What is not sea: the sky and the lights' discs.

layout(binding = PEL_UNIT_TRANSMITTANCE) uniform sampler2D transmittance;

#ifndef PEL_NO_DISC
// A disc, its edge softened over a pixel, darkened towards the limb (Hestroffer
// and Magnan 1998 at the mean wavelength).
vec3 light_disc(int i, vec3 dir, float blur)
{
    vec4 to = lights[i].direction;
    vec3 across = cross(dir, to.xyz);
    float off = sqrt(dot(across, across));
    vec3 disc = vec3(0.0);
    if (dot(dir, to.xyz) > 0.0 && off < to.w + blur) {
        float cover = 1.0 - smoothstep(to.w - 0.5 * blur, to.w + 0.5 * blur, off);
        float inside = min(off / to.w, 1.0);
        if (size.z > 0.5) {
            // The part of the pixel inside, and the middle of that part.
            cover = clamp((to.w - off) / blur + 0.5, 0.0, 1.0);
            inside = max(off - 0.5 * blur * (1.0 - cover), 0.0) / to.w;
        }
        vec3 power = 0.5 * lights[i].limb.rgb;
        vec3 limb = pow(vec3(max(1.0 - inside * inside, 1e-4)), power);
        disc = lights[i].irradiance.rgb / lights[i].irradiance.w * limb * (1.0 + power) * cover *
               transmittance_to_top(transmittance, eye.x, max(dir.z, horizon_cosine(eye.x)));
    }
    return disc;
}
#endif

shaded shade_backdrop(ivec2 at)
{
    vec3 ray = pixel_ray(lattice(at));
    float inverse = inversesqrt(dot(ray, ray));
    vec3 dir = ray * inverse;
    float angle = max(angle_above_horizon(dir), 0.0);
    vec3 disc = vec3(0.0);
    vec3 light = sky_light(eye_table, dir.xy, angle);
#ifndef PEL_NO_DISC
    float blur = pixel.x * inverse;
    for (int i = 0; i < PEL_LIGHTS; i++) {
        disc += light_disc(i, dir, blur);
    }
#endif
    shaded result = only_light(from_under_water(light + disc, dir.z));
#ifdef PEL_LAYERS
    result.depth = uintBitsToFloat(0x7F800000u); // no surface: infinity
    bool dry = lut.y < 0.5;
    result.sun = dry ? disc : vec3(0.0);
    result.sky = dry ? light : vec3(0.0);
    result.water = dry ? vec3(0.0) : result.radiance;
#endif
#ifdef PEL_WATER_PARTS
    set_parts(result, water_from_below(lut.y > 0.5 ? result.radiance : vec3(0.0)));
#endif
    return result;
}
