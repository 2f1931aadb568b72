// What is not sea: the sky and the lights' discs.

layout(binding = PEL_UNIT_TRANSMITTANCE) uniform sampler2D transmittance;

#ifndef PEL_NO_DISC
#if PEL_DISCS > 1
// Twin of pel_moon_disc, of mean 1 over the disc: dust as Lommel and Seeliger
// have it, and what the Earth lights of its night.
float lit_sphere(int i, vec3 dir, float blur)
{
    vec3 to = lights[i].direction.xyz, source = sources[i].xyz;
    vec3 off = (dir - to * dot(dir, to)) / lights[i].direction.w;
    float mu = sqrt(max(1.0 - dot(off, off), 0.0));
    // Away from its middle on our side.
    float mu_lit = dot(off - mu * to, source);
    float soft = 0.5 * blur / lights[i].direction.w;
    mu_lit = mu_lit > soft ? mu_lit : 0.25 * max(mu_lit + soft, 0.0) * max(mu_lit + soft, 0.0) / soft;
    return lights[i].limb.r * (mu_lit / max(mu_lit + mu, 1e-4) + sources[i].w);
}
#endif

// A disc, its edge softened over a pixel, darkened towards the limb (Hestroffer
// and Magnan 1998 at the mean wavelength), or lit from a side.
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
#if PEL_DISCS > 1
        if (sources[i].w > 0.0) {
            limb = vec3(lit_sphere(i, dir, blur));
            power = vec3(0.0);
        }
#endif
        disc = lights[i].irradiance.rgb / lights[i].irradiance.w * limb * (1.0 + power) * cover;
#ifndef PEL_SPACE // there by the air's own table
        disc *= transmittance_to_top(transmittance, eye.x, max(dir.z, horizon_cosine(eye.x)));
#endif
    }
    return disc;
}
#endif

#ifdef PEL_PANORAMA
#include "lib/panorama.glsl"
#endif

#ifdef PEL_NIGHT
#include "lib/night.glsl"
#include "lib/stars.glsl"
#endif

#ifdef PEL_CLOUDS
// What clouds add and leave in a pixel: between the nodes of cloudscape.frag by
// Catmull and Rom's cubic. Nodes and weights belong to the place on the lattice.
layout(binding = PEL_UNIT_CLOUDSCAPE) uniform sampler2D cloudscape;

vec4 cubic_weights(float f)
{
    float f2 = f * f, f3 = f2 * f;
    return vec4(-f3 + 2.0 * f2 - f, 3.0 * f3 - 5.0 * f2 + 2.0, -3.0 * f3 + 4.0 * f2 + f, f3 - f2) * 0.5;
}

vec4 clouds_before(ivec2 at)
{
    vec2 place = lattice(at) * size.w;
    vec2 node = floor(place);
    ivec2 from = ivec2(node - floor(pixel.zw * size.w));
    vec4 across = cubic_weights(place.x - node.x), down = cubic_weights(place.y - node.y);
    vec4 sum = vec4(0.0);
    for (int j = 0; j < 4; j++) {
        vec4 row = vec4(0.0);
        for (int i = 0; i < 4; i++) {
            row += texelFetch(cloudscape, from + ivec2(i, j), 0) * across[i];
        }
        sum += row * down[j];
    }
    return vec4(sum.rgb, clamp(sum.a, 0.0, 1.0));
}
#endif

shaded shade_backdrop(ivec2 at)
{
    vec3 ray = pixel_ray(lattice(at));
    float inverse = inversesqrt(dot(ray, ray));
    vec3 dir = ray * inverse;
    float angle = max(angle_above_horizon(dir), 0.0);
    vec3 disc = vec3(0.0);
#ifdef PEL_PANORAMA
    vec3 light = panorama_seen(dir, angle, pixel.x * inverse);
#else
    vec3 light = sky_light(eye_table, dir.xy, angle);
#endif
#ifdef PEL_NIGHT
    light += night_off(dir);
    vec3 starlight = vec3(0.0);
    vec4 stars = stars_of(at);
    if (stars.y > 0.0) {
        starlight = stars_at(at, stars, inverse) *
                    transmittance_to_top(transmittance, eye.x, max(dir.z, horizon_cosine(eye.x)));
    }
#if !defined(PEL_CLOUDS) && !defined(PEL_FOG)
    light += starlight;
#endif
#endif
#ifndef PEL_NO_DISC
    float blur = pixel.x * inverse;
    for (int i = 0; i < PEL_DISCS; i++) {
        disc += light_disc(i, dir, blur);
    }
#endif
#ifdef PEL_CLOUDS
    vec4 clouds = clouds_before(at);
    light = max(clouds.rgb + light * clouds.a, vec3(0.0));
    float beam = beam_behind_clouds(clouds.a);
    disc *= beam;
#ifdef PEL_NIGHT
    starlight *= beam;
#endif
#endif
#ifdef PEL_FOG
    fogged fog = fog_toward(vec3(0.0, 0.0, eye.x), dir, 1e7);
    light = foggy_sky(fog, light);
    disc *= exp(-fog.tau);
#ifdef PEL_NIGHT
    starlight *= exp(-fog.tau);
#endif
#endif
#if defined(PEL_NIGHT) && (defined(PEL_CLOUDS) || defined(PEL_FOG))
    light += starlight;
#endif
    shaded result = only_light(light + disc);
#ifdef PEL_LAYERS
    result.depth = uintBitsToFloat(0x7F800000u); // no surface: infinity
    result.sun = disc;
    result.sky = light;
#endif
    return result;
}
