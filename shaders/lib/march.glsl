// Radiance gathered along `way` metres of a ray from height h, and the
// transmittance of the way; `dir` and the light in the frame of the start.
void integrate_ray(int light, sampler2D transmittance, sampler2D multiple, float h, vec3 dir,
                   float way, int steps, out vec3 radiance, out vec3 through)
{
    float mu = dir.z;
    vec3 to = lights[light].direction.xyz;
    float nu = dot(dir, to);
    float phase_r = rayleigh_phase(nu);
    float phase_m = mie_phase(nu);
    vec2 table = vec2(textureSize(multiple, 0));
    radiance = vec3(0.0);
    through = vec3(1.0);
    float r = planet.x + h;
    float t0 = 0.0;
    for (int i = 0; i < steps; i++) {
        // Steps grow with the distance: the air near the eye counts most.
        float x = float(i + 1) / float(steps);
        float t1 = way * x * x;
        float t = 0.5 * (t0 + t1);
        float dt = t1 - t0;
        t0 = t1;
        float ht = max(height_along(h, mu, t), 0.0);
        float light_mu = clamp((r * to.z + t * nu) / (planet.x + ht), -1.0, 1.0);
        float dr = rayleigh_density(ht);
        float dm = mie_density(ht);
        vec3 scatter_r = rayleigh.rgb * dr;
        float scatter_m = mie.y * dm;
        vec3 sigma = max(scatter_r + mie.x * dm + ozone.rgb * ozone_density(ht), vec3(1e-12));
        vec3 direct = light_transmittance(transmittance, ht, light_mu, lights[light].direction.w);
        vec3 gain = textureLod(multiple, multiple_uv(ht, light_mu, table), 0.0).rgb;
        vec3 source = lights[light].irradiance.rgb * (direct * (scatter_r * phase_r + scatter_m * phase_m) +
                                                        gain * (scatter_r + scatter_m));
        vec3 step_through = exp(-sigma * dt);
        radiance += through * source * (1.0 - step_through) / sigma;
        through *= step_through;
    }
}
