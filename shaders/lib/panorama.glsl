// The sky of a picture (render/panoramamap.h) in place of the computed one. Its
// horizon is where the eye's is.
layout(binding = PEL_UNIT_PANORAMA) uniform sampler2D panorama_map;

// `to`: the level direction; radiance at a zenith angle and an angle above the
// horizon, of what is seen within `width`, all rad.
vec3 panorama_at(vec2 to, float zenith, float angle, float width)
{
    float lod = max(log2(width) + panorama[1].w, 0.0);
    float texels = float(textureSize(panorama_map, 0).y);
    // No further down than what is above the picture's horizon at this level.
    float lowest = 0.5 - 0.5 * exp2(ceil(lod)) / texels;
    vec2 uv = vec2(0.5 + (atan(to.x, to.y) - panorama[0].w) / (2.0 * PI),
                   min(0.5 * zenith / max(zenith + max(angle, 0.0), 1e-6), lowest));
    vec3 rgb = textureLod(panorama_map, uv, lod).rgb;
    return max(vec3(dot(panorama[0].rgb, rgb), dot(panorama[1].rgb, rgb), dot(panorama[2].rgb, rgb)),
               vec3(0.0));
}

vec3 panorama_seen(vec3 dir, float angle, float width)
{
    return panorama_at(dir.xy, acos(clamp(dir.z, -1.0, 1.0)), angle, width);
}
