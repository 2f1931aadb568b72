// What a sight from high up meets: the sea by the same filtered waves and BRDF as
// from below, land by its albedo, clouds by their mean, and the air before it.

layout(binding = PEL_UNIT_SPACE_LAND) uniform sampler2D land_share;    // by longitude and latitude
layout(binding = PEL_UNIT_SPACE_GROUND) uniform sampler2D land_albedo; // the same

// Light on a level face at the point, over π.
vec3 light_on_level()
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        sum += beam_there(i) * max(space_to[i].z, 0.0) + skies[i].rgb;
    }
    return sum * (1.0 / PI);
}

// Share of land in a footprint, and its albedo. Nearer than its texels the coast
// is where half of one is land.
float land_at(vec3 earth, float footprint, out vec3 albedo)
{
    albedo = vec3(0.0);
    if (space_more.x < 0.5) {
        return 0.0;
    }
    vec2 uv = vec2(atan(earth.y, earth.x) * (0.5 / PI) + 0.5,
                   atan(earth.z, length(earth.xy)) * (1.0 / PI) + 0.5);
    float texels = footprint * float(textureSize(land_share, 0).y) / (PI * planet.x);
    float share = textureLod(land_share, uv, log2(max(texels, 1.0))).r;
    share = clamp((share - 0.5) / clamp(texels, 0.04, 1.0) + 0.5, 0.0, 1.0);
    albedo = share > 0.0 ? textureLod(land_albedo, uv, 0.0).rgb : vec3(0.0);
    return share * space_eye.z;
}

#ifdef PEL_SPACE_WINDS
layout(binding = PEL_UNIT_SPACE_WINDS) uniform sampler2DArray earth_winds; // m/s, axes of the Earth; at two times
layout(binding = PEL_UNIT_SPACE_ROUGH) uniform sampler2D sea_rough; // slope variances, dense foam; crests

// Sets wind and crests to those of the point; its mean share of dense foam.
float wind_at(space_point p)
{
    wind = scene_wind();
    vec2 uv = vec2(atan(p.earth.y, p.earth.x) * (0.5 / PI) + 0.5,
                   atan(p.earth.z, length(p.earth.xy)) * (1.0 / PI) + 0.5);
    vec3 blows = mix(textureLod(earth_winds, vec3(uv, 0.0), 0.0).xyz,
                     textureLod(earth_winds, vec3(uv, 1.0), 0.0).xyz, space_winds.x);
    vec3 there = into_point(p, vec3(dot(space_earth[0].xyz, blows), dot(space_earth[1].xyz, blows),
                                    dot(space_earth[2].xyz, blows)));
    vec2 to = mix(wind.xy * space_winds.y, there.xy, space_eye.z);
    float speed = length(to);
    const float SPEEDS = float(PEL_WIND_SPEEDS);
    float at = (0.5 + min(speed / PEL_WIND_MOST, 1.0) * (SPEEDS - 1.0)) / SPEEDS;
    vec3 rough = textureLod(sea_rough, vec2(at, 0.25), 0.0).rgb;
    wind = vec4(speed > 1e-3 ? to / speed : wind.xy, max(rough.rg * space_winds.zw, vec2(1e-8)));
    crests = vec4(textureLod(sea_rough, vec2(at, 0.75), 0.0).rg, scene_crests().zw);
    return rough.b;
}
#endif

struct surface_seen {
    lit parts;
    vec3 normal; // mean, in the point's frame
    vec2 variance;
    float foam, land;
    vec3 albedo, leaving;
    water_light taken;
};

surface_seen sea_of(sampler2D map, vec3 dir, space_point p, float footprint)
{
    surface_seen o;
    vec3 v = -into_point(p, dir);
    v = vec3(v.xy, max(v.z, 1e-4));
    const vec2 LEVEL = vec2(0.0);
#if defined(PEL_METER) && defined(PEL_SPACE_WINDS)
    float dense = wind_at(p);
#endif
#ifdef PEL_METER
    const vec3 n = vec3(0.0, 0.0, 1.0);
    vec3 n_lit = n, glint = vec3(0.0);
    vec2 variance_seen = wind.zw;
    vec4 pressed = NOT_PRESSED;
    float beside = 0.0;
#ifdef PEL_SPACE_WINDS
    vec2 foam = vec2(dense, 1.0);
#else
    vec2 foam = vec2(whitecaps.w, 1.0);
#endif
#else
#ifdef PEL_SPACE_WINDS
    wind = scene_wind();
#endif
    filtered f;
    f.slope = vec2(0.0);
    f.fold = vec4(0.0);
#ifdef PEL_LAYERS
    f.shift = vec3(0.0);
#endif
#ifdef PEL_FOAM
    f.breaking = vec2(0.0);
#endif
#ifdef PEL_SHORE
    f.surf = vec2(0.0);
#endif
#ifdef PEL_AREAS
    f.up = 1.0;
    f.washed = vec3(0.0);
#endif
    if (footprint < space_more.y) {
        f = filtered_sea(p.x, footprint);
    }
#ifdef PEL_AREAS
    else {
        f.up = short_waves(p.x, footprint, f.washed);
    }
#endif
#ifdef PEL_WAKES
    wake_shift wake = wake_at(p.x - wake_at(p.x, footprint).d.xy, footprint);
    add_wakes(wake, f);
#endif
    vec2 variance = variance_left(footprint);
    vec2 variance_wide = variance_left(PEL_CELL_FOOTPRINT * footprint);
#ifdef PEL_SPACE_WINDS
    // The scene's waves as high as the wind there has them.
    float dense = wind_at(p);
    vec2 rougher = wind.zw / max(scene_wind().zw, vec2(1e-8));
    variance *= rougher;
    variance_wide *= rougher;
    float higher = sqrt(0.5 * (rougher.x + rougher.y));
    f.slope *= higher;
    f.fold *= min(higher, 1.0);
#endif
    vec3 n = filtered_normal(f);
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
    float edge = min(0.5 * v.z, 0.06);
    float hidden = 1.0 - smoothstep(-edge, edge, dot(n, v));
    vec3 n_seen = mix(n / n.z, vec3(0.0, 0.0, 1.0), hidden);
    n_seen = normalize(n_seen + toward_sight(v, v.z, variance_beside));
    vec2 variance_seen = mix(variance, variance_all, hidden);
    vec3 n_lit = facet_in_sight(n_seen, v);
    vec2 shown = max(variance_all - variance, vec2(1e-8));
    float beside = clamp((variance_beside.x + variance_beside.y) / (shown.x + shown.y), 0.0, 1.0);
    vec4 pressed = mix(vec4(1.0 - f.fold.x, -f.fold.z, -f.fold.y, 1.0 - f.fold.w), NOT_PRESSED, hidden);
    // Beyond a hundred of their waves they average out.
    vec3 glint = blue.w > 0.0 && footprint < 100.0 * PEL_GLINT_LONGEST ? vec3(glint_slopes(dir, footprint), glint_share(footprint)) : vec3(0.0);
    vec2 foam = vec2(0.0, 1.0);
#ifdef PEL_SPACE_WINDS
    vec4 there = wind, crests_there = crests;
    wind = scene_wind();
    crests = scene_crests();
#endif
#ifdef PEL_FOAM
#ifdef PEL_AREAS
    float up = f.up;
#else
    const float up = 1.0;
#endif
#ifdef PEL_SHORE
    foam = foam_of(p.x, f.breaking, footprint, up, f.surf);
#else
    foam = foam_of(p.x, f.breaking, footprint, up, vec2(0.0));
#endif
#endif
#ifdef PEL_SPACE_WINDS
    // The scene's structure where there is about as much.
    wind = there;
    crests = crests_there;
    float other = abs(dense - whitecaps.w) / max(max(dense, whitecaps.w), 1e-6);
    foam = mix(foam, vec2(dense, 1.0), min(other, 1.0));
#endif
#ifdef PEL_WASH
    foam = foams_together(foam, wash_foam(p.x, f.washed.y, footprint));
#endif
#endif
    o.leaving = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        o.leaving += space_leaving(i, water_place(v, n_lit, space_to[i]));
    }
    vec3 leaving = o.leaving;
#ifdef PEL_WASH
    leaving += light_of_bubbles(f.washed.z, LEVEL);
#endif
    o.parts = sea_radiance(map, v, LEVEL, n_lit, variance_seen, leaving, glint, pressed, beside);
#if defined(PEL_FOAM) || defined(PEL_WASH) || defined(PEL_METER) || defined(PEL_SPACE_WINDS)
    cover_by_foam(foam, n_lit, LEVEL, o.parts);
#endif
    o.normal = n;
    o.variance = variance_seen;
    o.foam = foam.x;
    vec3 albedo;
    o.land = land_at(p.earth, footprint, albedo);
    o.albedo = albedo;
    vec3 level = light_on_level();
    if (o.land > 0.0) {
        vec3 open = vec3(1.0 - o.land), shone = albedo * o.land * (1.0 / PI), direct = vec3(0.0), sky = vec3(0.0);
        for (int i = 0; i < PEL_LIT; i++) {
            direct += beam_there(i) * max(space_to[i].z, 0.0);
            sky += skies[i].rgb;
        }
        o.parts.sun = o.parts.sun * open + shone * direct;
        o.parts.sky = o.parts.sky * open + shone * sky;
        o.parts.water *= open;
    }
    if (space_more.z > 0.0) {
        float open = 1.0 - space_more.z;
        o.parts.sun *= open;
        o.parts.sky = o.parts.sky * open + level * (space_more.z * space_more.w);
        o.parts.water *= open;
        o.land *= open;
    }
    return o;
}

// Spray is on the way, too, where it is seen at all.
vec3 sprayed(inout vec3 air, vec3 through, float range)
{
    vec3 left = through * exp(-lut.z * range * (1.0 - water.w));
    air *= (1.0 - left) / max(1.0 - through, vec3(1e-6));
    return left;
}

#ifdef PEL_METER
// Light along a sight as a meter sees it.
vec3 space_seen(sampler2D map, sampler2D transmittance, vec3 dir)
{
    space_sight s = sight_of(dir);
    vec3 through;
    vec3 air = space_air(s, through);
    if (s.disc < 0.0) {
        return air;
    }
    space_point p = point_of(dir, s);
    light_point(transmittance, p);
    surface_seen seen_ = sea_of(map, dir, p, 1e5);
    through = sprayed(air, through, p.range);
    return (seen_.parts.sun + seen_.parts.sky + seen_.parts.water) * through + air;
}
#else
layout(binding = PEL_UNIT_REFLECTION) uniform sampler2D reflection_map;

shaded space_beyond(ivec2 at, vec3 dir, float inverse, space_sight s)
{
    vec3 through, disc = vec3(0.0);
    vec3 light = space_air(s, through);
#ifdef PEL_NIGHT
    vec4 stars = stars_of(at);
    if (stars.y > 0.0) {
        light += stars_at(at, stars, inverse) * through;
    }
#endif
#ifndef PEL_NO_DISC
    for (int i = 0; i < PEL_DISCS; i++) {
        disc += light_disc(i, dir, pixel.x * inverse) * through;
    }
#endif
    shaded result = only_light(light + disc);
#ifdef PEL_LAYERS
    result.depth = uintBitsToFloat(0x7F800000u);
    result.sun = disc;
    result.sky = light;
#endif
    return result;
}

shaded shade_space(ivec2 at, out float shows)
{
    vec3 ray = pixel_ray(lattice(at));
    float ray_length = sqrt(dot(ray, ray));
    vec3 dir = ray / ray_length;
    space_sight s = sight_of(dir);
    shows = PEL_SHOWS_SEA;
    if (s.disc < 0.0) {
        return space_beyond(at, dir, 1.0 / ray_length, s);
    }
    space_point p = point_of(dir, s);
    light_point(transmittance, p);
    float slant = max(-into_point(p, dir).z, 0.002);
    float footprint = p.range / ray_length * pixel.x * pow(slant, -PEL_FOOTPRINT_ALONG);
    surface_seen seen_ = sea_of(reflection_map, dir, p, footprint);
#ifdef PEL_SPACE_CLOUDS
    space_layer clouds = space_clouds(p, -into_point(p, dir), footprint);
    float open = clouds.seen.a;
    seen_.parts.sun *= open * clouds.beam;
    seen_.parts.sky *= open;
    seen_.parts.water *= open * clouds.light;
    seen_.land *= open;
#endif
    vec3 through;
    vec3 air = space_air(s, through);
#ifdef PEL_SPACE_CLOUDS
    // Clouds hide the air below them.
    vec3 to_clouds = pow(through, air_above_clouds(eye.x));
    vec3 before = air * (1.0 - to_clouds) / max(1.0 - through, vec3(1e-4));
    air *= air_below_clouds(eye.x);
#endif
    through = sprayed(air, through, p.range);
#ifdef PEL_SPACE_CLOUDS
    air = mix(before, air, open);
    seen_.parts.sky += clouds.seen.rgb * to_clouds / max(through, vec3(1e-6));
#endif
    lit parts = seen_.parts;
    shaded result = only_light((parts.sun + parts.sky + parts.water) * through + air);
    shows = seen_.land > 0.5 ? PEL_SHOWS_LAND : PEL_SHOWS_SEA;
#ifdef PEL_LAYERS
    bool land = seen_.land > 0.5;
    result.depth = p.range;
    result.normal = out_of_point(p, land ? vec3(0.0, 0.0, 1.0) : seen_.normal);
    result.fresnel = land ? 0.0 : parts.fresnel.g;
    result.foam = land ? 0.0 : seen_.foam;
    result.sun = parts.sun * through;
    result.sky = parts.sky * through;
    result.water = parts.water * through;
    result.air = air;
    result.slope_variance = land ? vec2(0.0) : seen_.variance;
    result.albedo = land ? seen_.albedo : vec3(0.0);
#endif
#ifdef PEL_WATER_PARTS
    // Shared as the nadir's is; what foam and bubbles add is scattered often.
    vec3 v = -into_point(p, dir);
    water_light part = water_parts(0, water_place(v, vec3(0.0, 0.0, 1.0), space_to[0]), 1e5, vec3(1.0));
    vec3 whole = part.single + part.second + part.higher + part.bottom;
    vec3 over = result.water / max(whole, vec3(1e-30));
    bvec3 dark = lessThan(whole, vec3(1e-25));
    part.single = mix(part.single * over, vec3(0.0), dark);
    part.second = mix(part.second * over, vec3(0.0), dark);
    part.bottom = mix(part.bottom * over, vec3(0.0), dark);
    part.higher = result.water - part.single - part.second - part.bottom;
    set_parts(result, part);
#endif
    return result;
}
#endif
