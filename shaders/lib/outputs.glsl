// The attachments of a fragment shader that shades.
#if defined(PEL_COLOR)
layout(location = 0) out vec4 color_out;
#elif defined(PEL_WATER_PARTS)
layout(location = 0) out vec4 single_out;
layout(location = 1) out vec4 second_out;
layout(location = 2) out vec4 higher_out;
layout(location = 3) out vec4 bottom_out;
#else
layout(location = 0) out vec4 radiance_out;
#endif
#ifdef PEL_LAYERS
layout(location = 1) out float depth_out;
layout(location = 2) out vec4 normal_out;
layout(location = 3) out vec4 sun_out;
layout(location = 4) out vec4 sky_out;
layout(location = 5) out vec4 water_out;
layout(location = 6) out vec4 air_out;
layout(location = 7) out vec2 variance_out;
#endif

void write_outputs(shaded s, ivec2 at)
{
#if defined(PEL_COLOR)
    color_out = vec4(display(s.radiance, at), 1.0);
#elif defined(PEL_WATER_PARTS)
    single_out = vec4(s.parts.single, 1.0);
    second_out = vec4(s.parts.second, 1.0);
    higher_out = vec4(s.parts.higher, 1.0);
    bottom_out = vec4(s.parts.bottom, 1.0);
#else
    radiance_out = vec4(s.radiance, 1.0);
#endif
#ifdef PEL_LAYERS
    depth_out = s.depth;
    normal_out = s.normal;
    sun_out = vec4(s.sun, 1.0);
    sky_out = vec4(s.sky, 1.0);
    water_out = vec4(s.water, 1.0);
    air_out = vec4(s.air, 1.0);
    variance_out = s.variance;
#endif
}
