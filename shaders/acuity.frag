#version 450 core
// What an eye loses of detail by little light: the light of a picture spread by
// a Gaussian of one angle everywhere. First along rows (PEL_ALONG_ROWS), then
// along lines that lean, so that both together are as wide in all directions of
// space (docs/physics/eye.md).
#include "lib/blocks.h"
#include "lib/vision.glsl"

layout(binding = PEL_UNIT_RADIANCE) uniform sampler2D radiance;
layout(binding = PEL_UNIT_ACUITY_ROWS) uniform sampler2D rows;
layout(location = 0) out vec4 spread;

// Of a texel's light what is spread; points, discs and glints stay.
vec3 soft(ivec2 at, float most)
{
    vec3 light = texelFetch(radiance, clamp(at, ivec2(0), ivec2(size.xy) - 1), 0).rgb;
    vec3 weights = 0.2126 * red.rgb + 0.7152 * green.rgb + 0.0722 * blue.rgb;
    float l = dot(weights, light);
    return l > most ? light * (most / l) : light;
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec2 p = (pixel.zw + vec2(at) + 0.5) * pixel.xy;
    float y2 = 1.0 + p.y * p.y, r2 = y2 + p.x * p.x;
    float angle = eye_blur(exposure.y), most = PEL_ACUITY_SHARP * exp2(exposure.y);
#ifdef PEL_ALONG_ROWS
    float wide = angle * r2 * inversesqrt(y2) / pixel.x;
    vec3 sum = soft(at, most);
#else
    float wide = angle * sqrt(r2 * y2) / pixel.y;
    float lean = p.x * p.y / y2 * pixel.y / pixel.x;
    vec3 sum = texelFetch(rows, at, 0).rgb;
#endif
    wide = clamp(wide, 1e-3, PEL_ACUITY_WIDEST);
    float all = 1.0, narrow = -0.72135 / (wide * wide);
    int reach = wide < 0.15 ? 0 : int(ceil(3.0 * wide));
    for (int i = 1; i <= reach; i++) {
        float w = exp2(narrow * float(i * i));
#ifdef PEL_ALONG_ROWS
        sum += w * (soft(at - ivec2(i, 0), most) + soft(at + ivec2(i, 0), most));
#else
        ivec2 off = ivec2(int(floor(lean * float(i) + 0.5)), i), last = ivec2(size.xy) - 1;
        sum += w * (texelFetch(rows, clamp(at - off, ivec2(0), last), 0).rgb +
                    texelFetch(rows, clamp(at + off, ivec2(0), last), 0).rgb);
#endif
        all += 2.0 * w;
    }
    sum /= all;
#ifndef PEL_ALONG_ROWS
    sum += texelFetch(radiance, at, 0).rgb - soft(at, most);
#endif
    spread = vec4(sum, 1.0);
}
