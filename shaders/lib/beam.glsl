// The beams of the lights at the place that is shaded.
#ifdef PEL_CLOUDS
layout(binding = PEL_UNIT_CLOUD_SHADE) uniform sampler2D cloud_shade; // by place in the tile, a channel a light
#endif
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
float lights_leave[PEL_LIT]; // of each, set before a surface is shaded

float beam_share(int i)
{
    return lights_leave[i];
}

vec3 beam_there(int i)
{
    return beams[i].rgb * lights_leave[i];
}

// At x, m from the eye's nadir, so high above the sea.
void veil_lights(vec2 x, float height, float footprint)
{
#ifdef PEL_FOG
    vec2 tilt = x / planet.x;
#endif
    for (int i = 0; i < PEL_LIT; i++) {
        lights_leave[i] = 1.0;
#ifdef PEL_CLOUDS
        lights_leave[i] =
            textureLod(cloud_shade, cloud_shade_place(x, lights[i].direction.xyz), cloud_lod(footprint))[i];
#endif
#ifdef PEL_FOG
        lights_leave[i] *= exp(-fog_to_light(vec3(x, height), i, light_above(i, tilt)));
#endif
    }
}

// By the mean of clouds, and the fog at the eye's nadir.
void veil_lights_evenly()
{
    for (int i = 0; i < PEL_LIT; i++) {
        lights_leave[i] = 1.0;
#ifdef PEL_CLOUDS
        lights_leave[i] = cloud_light.y;
#endif
#ifdef PEL_FOG
        lights_leave[i] *= exp(-fog_to_light(vec3(0.0), i, lights[i].direction.xyz));
#endif
    }
}

// What they leave of the light that leaves the water, which was computed
// without.
vec3 water_veiled(vec2 tilt)
{
    vec3 direct = vec3(0.0), left = vec3(0.0), sky = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        vec3 one = beams[i].rgb * max(light_above(i, tilt).z, 0.0);
        direct += one;
        left += one * lights_leave[i];
        sky += skies[i].rgb;
    }
    return (left + sky) / max(direct + sky / max(incident.yzw, vec3(1e-4)), vec3(1e-20));
}
#else
float beam_share(int i)
{
    return 1.0;
}

vec3 beam_there(int i)
{
    return beams[i].rgb;
}
#endif
