// Shades a pixel of the sea from the number of its triangle: exact place at
// rest, per-pixel normal (eq. 3), slope variance as total minus resolved
// (eq. 4), light, haze. Included by a fragment and by a compute wrapper.
#include "lib/cut.glsl"

layout(binding = PEL_UNIT_REFLECTION) uniform sampler2D reflection_map;

#ifdef PEL_LAYERS
// Where the ray meets the surface near t, the cut of its triangle: the mesh is
// within a pixel of it, but at grazing sight a pixel of height is many metres
// of distance. Waves count that are as long as the pixel is wide: what is seen
// of crests is their height, however deep the pixel lies along the sight.
// Newton's steps, kept between a point above and one below the surface.
float surface_distance(vec2 x, vec3 ray, float t)
{
    float across = t * pixel.x;
    float steep = sqrt(ray.x * ray.x + ray.y * ray.y) * sqrt(wind.z + wind.w);
    float least_slant = 0.2 * (abs(ray.z) + steep);
    float least = 1e30;
    float best = t;
    vec2 reach = t + vec2(-1.0, 1.0) * min((4.0 * across + 0.1) / max(abs(ray.z), 0.005), 0.5 * t);
    vec2 between = reach;
    for (int i = 0; i < 16; i++) {
        filtered f = filtered_sea(x, across);
#ifdef PEL_WAKES
        add_wakes(wake_at(x + f.shift.xy, across), f);
#endif
        float half_arc = 0.5 * length(x) / planet.x;
        vec3 point = vec3(x * cos(half_arc) + f.shift.xy,
                          f.shift.z - 2.0 * planet.x * sin(half_arc) * sin(half_arc) - eye.x);
        vec3 n = filtered_normal(f);
        vec2 tilt = x / planet.x;
        n = vec3(n.xy + tilt * n.z, n.z - dot(tilt, n.xy));
        vec2 off = t * ray.xy - point.xy;
        float above = t * ray.z - point.z + dot(n.xy, off) / n.z;
        float slant = ray.z + dot(n.xy, ray.xy) / n.z;
        vec2 along = vec2(0.0);
        // Below the point of the ray, to first order.
        if (dot(off, off) < across * across * 0.06) {
            if (abs(above) < least) {
                least = abs(above);
                best = t;
            }
            if (least < 0.004 * across + 2e-5) {
                break;
            }
            between = above > 0.0 ? vec2(t, between.y) : vec2(between.x, t);
            float to = t + above / max(-slant, least_slant);
            if (to <= between.x || to >= between.y) {
                to = 0.5 * (between.x + between.y);
            }
            along = (to - t) * ray.xy;
            t = to;
        }
        // The particle that is carried there: a far one is not the near one's
        // neighbour.
        vec4 d = vec4(1.0 - f.fold.x, -f.fold.yz, 1.0 - f.fold.w);
        float det = max(d.x * d.w - d.y * d.z, 0.05);
        x += vec2(d.w * off.x - d.y * off.y, d.x * off.y - d.z * off.x) / det + along;
    }
    return best;
}
#endif

shaded shade_sea(ivec2 at, uint triangle)
{
    vec3 ray = pixel_ray(lattice(at));
    cut hit = cut_triangle(ray, triangle);
    vec2 x = hit.x;
    float t = hit.t;

    // The patch's frame: the sphere's up at its place.
    float ray_length = sqrt(dot(ray, ray));
    vec3 dir = ray / ray_length;
    float range = t * ray_length;
    vec2 tilt = dir.xy * (range / planet.x);
    vec3 v = -vec3(dir.xy - tilt * dir.z, dir.z + dot(tilt, dir.xy));
    v = normalize(v);

    // Length of the pixel on the surface, between its width and its length along
    // the line of sight, by PEL_FOOTPRINT_ALONG: waves that run across the line
    // keep their slopes in a pixel however long it is, and of those along it it
    // holds so few that its mean is theirs. On the mean plane, longer where the
    // waves turn their backs, as crests do before they hide what is behind.
    float facing = max(abs(dot(hit.facet, dir)), 0.15 * v.z);
    float footprint = t * pixel.x * pow(max(facing, 0.002), -PEL_FOOTPRINT_ALONG);
    filtered f = filtered_sea(x, footprint);
#ifdef PEL_WAKES
    // The place is above what the wakes have carried there, to first order.
    vec2 above = dir.xy * range;
    wake_shift wake = wake_at(above - wake_at(above, footprint).d.xy, footprint);
    add_wakes(wake, f);
#endif
    vec3 n = filtered_normal(f);
    vec2 variance = variance_left(footprint);
    vec2 variance_wide = variance_left(max(hit.cell, PEL_CELL_FOOTPRINT * footprint));
    vec2 variance_all = wind.zw;
#ifdef PEL_AREAS
    variance_wide = area_variance(variance_wide, f.up);
    variance = area_variance(variance, f.up);
    variance_all = area_variance(variance_all, f.up);
#endif
    vec2 variance_beside = variance_wide - variance;
#ifdef PEL_WAKES
    variance += wake_variance(wake.lost);
    variance_all += wake_variance(wake.lost);
#endif
    // A normal that faces away belongs to a patch which the mesh shows and the
    // waves hide. Such pixels dot the crests; they get what their neighbourhood
    // has on average, the mean plane with all its slopes, leaned where the eye is
    // below the wave until it is not seen from behind.
    float edge = min(0.5 * abs(v.z), 0.06);
    float hidden = 1.0 - smoothstep(-edge, edge, dot(n, v));
    vec3 level = v.z > 0.0 ? vec3(0.0, 0.0, 1.0)
                           : vec3(v.xy * (-v.z / max(dot(v.xy, v.xy), 1e-4)), 1.0);
    vec3 n_seen = mix(n / n.z, level, hidden);
    n_seen = normalize(n_seen + toward_sight(v, facing, variance_beside));
    vec2 variance_seen = mix(variance, variance_all, hidden);
    vec3 n_lit = facet_in_sight(n_seen, v);
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    veil_lights(dir.xy * range, 0.0, footprint);
#endif
#ifdef PEL_SEABED
    bed_view seen = seabed_seen(dir.xy * range, sight_height(dir, range), v, n_lit);
    vec3 to = light_above(0, tilt);
    bed_light below = seabed_light(0, water_place(v, n_lit, to), seen, footprint, to);
#if PEL_LIT > 1 // a loop, even of no turn, costs the first its order of operations
    for (int i = 1; i < PEL_LIT; i++) {
        to = light_above(i, tilt);
        bed_light more = seabed_light(i, water_place(v, n_lit, to), seen, footprint, to);
        below.volume += more.volume;
        below.bottom += more.bottom;
    }
#endif
    vec3 leaving = below.volume + below.bottom;
    float depth = seen.depth;
#else
    const float depth = 1e5; // the deepest there is
    vec3 leaving = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        leaving += leaving_deep_water(i, water_place(v, n_lit, light_above(i, tilt)));
    }
#endif
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    leaving *= water_veiled(tilt);
#endif
#ifdef PEL_WASH
    vec3 aerated = light_of_bubbles(f.washed.z, tilt);
    leaving += aerated;
#endif
#ifdef PEL_OBJECTS
    sea_place = t * ray;
    sea_pixel = lattice(at);
#ifdef PEL_SHADED
    sea_lit = sun_on_sea(sea_place);
    vec3 falling = beam_there(PEL_LIGHT_FIRST) * max(light_above(PEL_LIGHT_FIRST, tilt).z, 0.0);
    leaving *= 1.0 - (1.0 - sea_lit) * falling / max(falling + skies[PEL_LIGHT_FIRST].rgb, vec3(1e-12));
    if (objects_near.z != 0) {
        leaving = leaving_with_hulls(v, n_lit, light_above(PEL_LIGHT_FIRST, tilt), leaving);
    }
#endif
#endif
#ifdef PEL_LAMPS
    lamps_from = dir * range;
    lamps_footprint = footprint;
    lamps_about(at);
#endif
    vec2 shown = max(variance_all - variance, vec2(1e-8));
    float beside = clamp((variance_beside.x + variance_beside.y) / (shown.x + shown.y), 0.0, 1.0);
    lit parts = sea_radiance(reflection_map, v, tilt, n_lit, variance_seen, leaving,
                             blue.w > 0.0 ? vec3(glint_slopes(dir, footprint), glint_share(footprint)) : vec3(0.0),
                             mix(vec4(1.0 - f.fold.x, -f.fold.z, -f.fold.y, 1.0 - f.fold.w), NOT_PRESSED, hidden),
                             beside);
#if defined(PEL_FOAM) || defined(PEL_WASH)
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
    vec2 foam = foam_of(x, f.breaking, footprint, up, surf);
#else
    vec2 foam = vec2(0.0, 1.0);
#endif
#ifdef PEL_WASH
    foam = foams_together(foam, wash_foam(x, f.washed.y, footprint));
#endif
    cover_by_foam(foam, n_lit, tilt, parts);
#endif
    vec3 light = parts.sun + parts.sky + parts.water;

    vec3 air;
    vec3 through = haze(dir, range, air);
    light = light * through + air;
#ifdef PEL_CLOUDS_BELOW
    clouded below_eye = clouds_toward(transmittance, dir, air, through, pixel.x / ray_length, range);
    light = below_eye.light + light * below_eye.before;
#endif
    shaded result = only_light(light);
#ifdef PEL_LAYERS
    if (wants_layer(AT_DEPTH)) {
        result.depth = ray_length * surface_distance(x, ray, t);
    }
    result.normal = normalize(vec3(n.xy + tilt * n.z, n.z - dot(tilt, n.xy)));
    result.fresnel = parts.fresnel.g;
#if defined(PEL_FOAM) || defined(PEL_WASH)
    result.foam = foam.x;
#endif
    result.sun = parts.sun * through;
    result.sky = parts.sky * through;
    result.water = parts.water * through;
    result.air = air;
    result.slope_variance = variance_seen;
#endif
#ifdef PEL_WATER_PARTS
    water_light taken = water_light(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
    for (int i = 0; i < PEL_LIT; i++) {
        water_light one = water_parts(i, water_place(v, n_lit, light_above(i, tilt)), depth,
                                      1.0 - parts.fresnel);
        taken.single += one.single;
        taken.second += one.second;
        taken.higher += one.higher;
        taken.bottom += one.bottom;
    }
#ifdef PEL_SEABED
    // The sum is what was drawn.
    vec3 volume = (1.0 - parts.fresnel) * below.volume;
    taken.single = min(taken.single, volume);
    taken.second = min(taken.second, volume - taken.single);
    taken.higher = volume - taken.single - taken.second;
    taken.bottom = (1.0 - parts.fresnel) * below.bottom;
#endif
#ifdef PEL_WASH
    taken.higher += (1.0 - parts.fresnel) * aerated;
#endif
#if defined(PEL_FOAM) || defined(PEL_WASH)
    through *= 1.0 - foam.x; // which the air no longer needs
#endif
    taken.single *= through;
    taken.second *= through;
    taken.higher *= through;
    taken.bottom *= through;
    set_parts(result, taken);
#endif
    return result;
}
