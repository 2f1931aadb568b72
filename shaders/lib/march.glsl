// Radiance gathered along `way` metres of a ray from height h, and the
// transmittance of the way; `dir` and the light in the frame of the start.
void integrate_ray(int light, sampler2D transmittance, sampler3D airlight, float h, vec3 dir,
                   float way, int steps, out vec3 radiance, out vec3 through)
{
    float mu = dir.z;
    float across = length(dir.xy);
    float zenith = atan(across, mu);
    vec3 to = lights[light].direction.xyz;
    float nu = dot(dir, to);
    float phase_r = rayleigh_phase(nu);
    float phase_m = mie_phase(nu);
    radiance = vec3(0.0);
    through = vec3(1.0);
    float r = planet.x + h;
    // Steps grow with the distance: the air near the eye counts most. The first
    // is no thicker than a fifth of an optical depth.
    float thick = rayleigh.g * rayleigh_density(h) + mie.x * mie_density(h);
    float power = max(3.0, log(max(5.0 * way * thick, 1.0)) / log(float(steps)));
    float t0 = 0.0;
    for (int i = 0; i < steps; i++) {
        float t1 = way * pow(float(i + 1) / float(steps), power);
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
        // The vertical turns along the ray, and with it the azimuths.
        float there = max(zenith - atan(t * across, r + t * mu), 0.0);
        float sines = sin(there) * sqrt(max(1.0 - light_mu * light_mu, 0.0));
        float turn = (nu - cos(there) * light_mu) / max(sines, 1e-6);
        vec3 before = airlight_at(airlight, ht, dr, dm, light_mu, there,
                                  sqrt(clamp(0.5 - 0.5 * turn, 0.0, 1.0)));
        vec3 source = lights[light].irradiance.rgb * (direct * (scatter_r * phase_r + scatter_m * phase_m) +
                                                      before * (scatter_r + scatter_m));
        vec3 step_through = exp(-sigma * dt);
        radiance += through * source * (1.0 - step_through) / sigma;
        through *= step_through;
    }
}
