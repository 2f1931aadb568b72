// Wind by place (render/windmap.h): what the light of the sea takes as the scene's
// `wind` and `crests` is that of the point that is shaded (lib/spacesea.glsl).
vec4 scene_wind()
{
    return wind;
}

vec4 scene_crests()
{
    return crests;
}

vec4 wind_here = vec4(1.0, 0.0, 1e-8, 1e-8), crests_here = vec4(0.0); // set by wind_at
#undef wind
#define wind wind_here
#define crests crests_here
