// How a lamp's light is spread over pixels, by a pixel's middle from its place:
// not normalised.
float lamp_spread(vec2 off, float radius)
{
    float x = max(1.0 - dot(off, off) / (radius * radius), 0.0);
    return x * x * x;
}

// Of the light of a lamp (pel_shader_spot) what a pixel gets whose middle is off
// its place.
vec3 lamp_in_pixel(vec2 off, vec4 light, vec4 halo, vec4 place)
{
    vec3 sum = light.rgb * lamp_spread(off, light.w);
    // Less what it has at its end, where it stops.
    float core2 = place.z * place.z;
    float rest = 1.0 / (1.0 + dot(off, off) / core2) - 1.0 / (1.0 + halo.w * halo.w / core2);
    return sum + halo.rgb * max(rest, 0.0);
}
