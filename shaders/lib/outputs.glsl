// The attachments of a fragment shader that shades.
layout(location = 0) out vec4 radiance_out;
#ifdef PEL_LAYERS
layout(location = 1) out float depth_out;
layout(location = 2) out vec4 normal_out;
layout(location = 3) out vec4 sun_out;
layout(location = 4) out vec4 sky_out;
layout(location = 5) out vec4 water_out;
layout(location = 6) out vec4 air_out;
layout(location = 7) out vec2 variance_out;
#endif

void write_outputs(shaded s)
{
    radiance_out = vec4(s.radiance, 1.0);
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
