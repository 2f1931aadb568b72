// What waves leave on a hull; twin of optics/wet.h.

// `above`: the waterline.
float wet_share(float above, float deviation)
{
    float h = above / max(deviation, 1e-6);
    float missed = 1.0 - exp(-0.5 * h * h);
    return h <= 0.0 ? 1.0 : 1.0 - pow(max(missed, 1e-30), float(PEL_WET_WAVES));
}

vec3 wet_reflectance(vec3 dry)
{
    return (1.0 - PEL_WET_OUTSIDE) * (1.0 - PEL_WET_INSIDE) * dry / (1.0 - PEL_WET_INSIDE * dry);
}
