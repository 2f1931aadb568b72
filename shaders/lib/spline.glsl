// Uniform cubic B-spline of the four texels around, and its derivative.
void cubic_spline(vec2 f, out vec2 w[4], out vec2 d[4])
{
    vec2 g = 1.0 - f;
    w = vec2[4](g * g * g / 6.0, (4.0 - 6.0 * f * f + 3.0 * f * f * f) / 6.0,
                (4.0 - 6.0 * g * g + 3.0 * g * g * g) / 6.0, f * f * f / 6.0);
    d = vec2[4](-0.5 * g * g, f * (1.5 * f - 2.0), g * (2.0 - 1.5 * g), 0.5 * f * f);
}
