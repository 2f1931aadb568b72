// The beams of the lights at the place that is shaded.
#ifdef PEL_CLOUDS
layout(binding = PEL_UNIT_CLOUD_SHADE) uniform sampler2D cloud_shade; // by place in the tile, a channel a light
float clouds_leave[PEL_LIT]; // of each, set before a surface is shaded

vec3 beam_there(int i)
{
    return beams[i].rgb * clouds_leave[i];
}

// At x, m from the eye's nadir.
void shade_by_clouds(vec2 x, float footprint)
{
    vec4 left = textureLod(cloud_shade, cloud_place(x), cloud_lod(footprint));
    for (int i = 0; i < PEL_LIT; i++) {
        clouds_leave[i] = left[i];
    }
}

void below_mean_clouds()
{
    for (int i = 0; i < PEL_LIT; i++) {
        clouds_leave[i] = cloud_light.y;
    }
}

// What clouds leave of the light that leaves the water, which was computed
// without.
vec3 water_below_clouds(vec2 tilt)
{
    vec3 direct = vec3(0.0), left = vec3(0.0), sky = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        vec3 one = beams[i].rgb * max(light_above(i, tilt).z, 0.0);
        direct += one;
        left += one * clouds_leave[i];
        sky += skies[i].rgb;
    }
    return (left + sky) / max(direct + sky / max(incident.yzw, vec3(1e-4)), vec3(1e-20));
}
#else
vec3 beam_there(int i)
{
    return beams[i].rgb;
}
#endif
