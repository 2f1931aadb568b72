// A pixel where there may be land or shallow water: whichever of land, sea and
// sky the line of sight meets first.

// The ground as a diffuse reflector, dry or wetted by the waves.
shaded shade_land(vec3 dir, float range)
{
    vec2 x = dir.xy * range;
    vec2 node = bed_node(x);
    vec2 tilt = x / planet.x;
    vec3 v = -normalize(vec3(dir.xy - tilt * dir.z, dir.z + dot(tilt, dir.xy)));
    float across = range * pixel.x;
    vec3 n = seabed_normal(node, across / max(v.z, 0.05));
    float height = sight_height(dir, range);
    float wet = 1.0 - smoothstep(0.6 * bed_beyond.y, bed_beyond.y + 0.02, height);
    vec3 albedo = mix(bed_dry.rgb, bed_wet.rgb, wet) * (1.0 / PI);
    vec3 by_lights = vec3(0.0);
    vec3 by_sky = vec3(0.0);
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    veil_lights(x, height, across / max(v.z, 0.05));
#endif
    for (int i = 0; i < PEL_LIT; i++) {
        by_lights += albedo * beam_there(i) * max(dot(n, light_above(i, tilt)), 0.0);
        by_sky += albedo * skies[i].rgb * (0.5 + 0.5 * n.z);
    }
#ifdef PEL_LAMPS
    by_lights += albedo * lamps_on_face(dir * range, n);
#endif
    vec3 air;
    vec3 through = haze(dir, range, air);
    shaded result = only_light((by_lights + by_sky) * through + air);
#ifdef PEL_LAYERS
    result.depth = range;
    result.normal = normalize(vec3(n.xy + tilt * n.z, n.z - dot(tilt, n.xy)));
    result.sun = by_lights * through;
    result.sky = by_sky * through;
    result.air = air;
    result.albedo = albedo * PI;
#endif
    return result;
}

// Whether waves that stand `height` above the sea's zero wet the land there:
// they lose their height as they run up, so that what the unbroken waves behind
// would reach on their own stays dry.
bool runs_up(vec2 x, float height)
{
    float ground = seabed_height(bed_node(x));
    float tallest = 0.125 * bed_beyond.y;
    return ground <= 0.0 || height > ground * (1.0 + ground / tallest);
}

// How far along a pixel's sight land is, -1: nowhere before the water that the
// triangle shows.
float land_distance(vec3 ray, uint triangle, float ray_length)
{
    float limit = 1e7;
    if (triangle != 0u) {
        limit = cut_triangle(ray, triangle).t * ray_length;
        vec3 dir = ray / ray_length;
        if (!runs_up(dir.xy * limit, sight_height(dir, limit))) {
            limit = 1e7;
        }
    }
    return seabed_distance(ray / ray_length, limit);
}

// `shows`: PEL_SHOWS_*.
shaded shade_coast(ivec2 at, uint triangle, out float shows)
{
    vec3 ray = pixel_ray(lattice(at));
    float ray_length = length(ray);
    float range = land_distance(ray, triangle, ray_length);
    shows = range >= 0.0 ? PEL_SHOWS_LAND : PEL_SHOWS_SEA;
    if (range >= 0.0) {
        return shade_land(ray / ray_length, range);
    }
    if (triangle == 0u) {
        return shade_backdrop(at);
    }
    return shade_sea(at, triangle);
}
