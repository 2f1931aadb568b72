// What drops and flakes near the eye look like. Includers have lib/beam.glsl.

// Streaks towards the axis that they fall along come at the eye: they fade.
float aside(float sine)
{
    return smoothstep(PEL_FALL_SINE_LEAST, PEL_FALL_SINE_WHOLE, sine);
}

// A drop refracts, upside down, what lies in a cone of 165 degrees about the way
// on, nearly half of all directions (Garg and Nayar 2004); a flake scatters
// light from everywhere.
vec3 fallen_light(vec3 dir, bool flake)
{
    const float lets = 0.94;
    const float albedo = 0.9;
    vec3 sky = vec3(0.0);
    vec3 direct = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        sky += skies[i].rgb / PI;
        float ahead = max(dot(dir, lights[i].direction.xyz), 0.0);
        ahead *= ahead;
        direct += beam_there(i) * (flake ? 0.25 / PI : 2.5 / PI * ahead * ahead);
    }
    // Waves mirror a tenth of the sky.
    vec3 sea = sea_light.rgb + 0.1 * sky;
    float up = flake ? 0.5 + 0.2 * dir.z : 0.5 + 0.5 * dir.z;
    return (mix(sea, sky, up) + direct) * (flake ? albedo : lets);
}
