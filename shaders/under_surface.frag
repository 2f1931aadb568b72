#version 450 core
// The surface from below in a pixel: its mean normal, towards whose back one
// looks, the variance of its slopes, and its foam. By itself: software devices
// compile its loops and what looks up foam in half a second, and within the program
// that shades it in half a minute.
#define PEL_UNDER
#include "lib/blocks.h"
#include "lib/turns.glsl"
#ifdef PEL_AREAS
#include "lib/areas.glsl"
#endif
#include "lib/spline.glsl"
#ifdef PEL_SHORE
#include "lib/shore.glsl"
#endif
#ifdef PEL_FFT
#include "lib/cascades.glsl"
#else
#include "lib/waves.glsl"
#endif
#include "lib/filtered.glsl"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/beam.glsl"
#include "lib/variance.glsl"
#include "lib/ray.glsl"
#include "lib/cut.glsl"
#if defined(PEL_FOAM) || defined(PEL_WASH)
#include "lib/foam.glsl"
#include "lib/ross.glsl"
#include "lib/water.glsl"
#include "lib/underlight.glsl"
#endif

layout(binding = PEL_UNIT_TRIANGLES) uniform usampler2D triangles;
layout(binding = PEL_UNIT_UNDER_FOUND) uniform sampler2D under_found; // of under_find.frag
layout(location = 0) out vec4 normal_out; // w: variance of slopes along the wind
layout(location = 1) out vec4 foam_out;   // x: variance across it; yz: foam (lib/foam.glsl)
#if defined(PEL_FOAM) || defined(PEL_WASH)
layout(location = 2) out vec4 back_out; // rgb: irradiance from below
#endif

vec2 surface_foam(vec2 x, filtered f, float footprint)
{
    vec2 foam = vec2(0.0, 1.0);
#ifdef PEL_AREAS
    float up = f.up;
#else
    const float up = 1.0;
#endif
#ifdef PEL_SHORE
    vec2 surf = f.surf;
#else
    const vec2 surf = vec2(0.0);
#endif
#ifdef PEL_FOAM
    foam = foam_of(x, f.breaking, footprint, up, surf);
#endif
#ifdef PEL_WASH
    foam = foams_together(foam, wash_foam(x, f.washed.y, footprint));
#endif
    return foam;
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 found = texelFetch(under_found, at, 0);
    if (found.y != PEL_UNDER_SURFACE) {
        discard;
    }
    vec3 ray = pixel_ray(lattice(at));
    vec3 sight = normalize(ray);
    float s = found.x;
    uint triangle = texelFetch(triangles, at, 0).r;
    vec3 place = s * sight;
    cut hit = cut_triangle(ray, triangle);
    vec2 x = triangle == 0u ? place.xy : hit.x;
    vec3 facet = triangle == 0u ? vec3(0.0, 0.0, 1.0) : hit.facet;
    float facing = max(abs(dot(facet, sight)), 0.05);
    float footprint = max(s * pixel.x * pow(facing, -PEL_FOOTPRINT_ALONG), 1e-3);
    filtered f = filtered_sea(x, footprint);
#ifdef PEL_WAKES
    wake_shift wake = wake_at(place.xy - wake_at(place.xy, footprint).d.xy, footprint);
    add_wakes(wake, f);
#endif
    vec2 foam = surface_foam(x, f, footprint);
    vec3 n = filtered_normal(f);
    vec2 variance = variance_left(footprint);
#ifdef PEL_AREAS
    variance = area_variance(variance, f.up);
#endif
#ifdef PEL_WAKES
    variance += wake_variance(wake.lost);
#endif
    // A patch that the mesh shows and the waves hide is seen edge on.
    float turned = dot(n, sight);
    n = turned < 0.02 ? normalize(n + (0.02 - turned) * sight) : n;
    normal_out = vec4(n, variance.x);
    foam_out = vec4(variance.y, foam, 0.0);
#if defined(PEL_FOAM) || defined(PEL_WASH)
    veil_water();
    back_out = vec4(under_flux(0.0, 1.0), 0.0);
#endif
}
