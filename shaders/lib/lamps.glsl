// How a lamp's light is spread over pixels, by a pixel's middle from its place:
// not normalised.
float lamp_spread(vec2 off, float radius)
{
    float x = max(1.0 - dot(off, off) / (radius * radius), 0.0);
    return x * x * x;
}
