// The sea from high up: sights in the frame where the ellipsoid is a sphere
// (render/spacegeometry.h), the air along them from the eye's table, and the
// light at each point of the ground by its own lights' elevations (Bruneton et al.
// 2010, section 6).

layout(binding = PEL_UNIT_SPACE_AIR) uniform sampler2DArray space_airs; // log2, a layer a light
layout(binding = PEL_UNIT_SPACE_THROUGH) uniform sampler2D space_throughs; // log2

// Product of a column of space_from and a vector of either frame.
vec3 into_sphere(vec3 v)
{
    return v.x * space_from[0].xyz + v.y * space_from[1].xyz + v.z * space_from[2].xyz;
}

vec3 out_of_sphere(vec3 v)
{
    return vec3(dot(space_from[0].xyz, v), dot(space_from[1].xyz, v), dot(space_from[2].xyz, v));
}

struct space_sight {
    vec3 dir;     // in the sphere's frame
    float longer; // lengths there by those of the eye's frame
    float disc;   // squared length of half the chord in the ground; below 0 it passes
};

// Twin of pel_space_meets, by the difference to the horizon: nothing cancels.
space_sight sight_of(vec3 dir)
{
    space_sight s;
    vec3 d = into_sphere(dir);
    s.longer = sqrt(dot(d, d));
    s.dir = d / s.longer;
    float r = planet.x + space_eye.x;
    float chord = r * r * (s.dir.z - space_eye.y) * (s.dir.z + space_eye.y);
    s.disc = s.dir.z < 0.0 ? chord : min(chord, -1.0);
    return s;
}

// Distance to the ground, in metres of the sphere's frame.
float sight_length(space_sight s)
{
    float r = planet.x + space_eye.x;
    return space_eye.x * (planet.x + r) / (-r * s.dir.z + sqrt(max(s.disc, 0.0)));
}

// Row of the table: the elevation of the eye where the sight meets the ground,
// its least height, or its elevation at the eye, by their roots.
float space_row(space_sight s)
{
    const float LIMB = float(PEL_SPACE_GROUND_ROWS);
    const float UP = float(PEL_SPACE_GROUND_ROWS + PEL_SPACE_LIMB_ROWS);
    const float ROWS = float(PEL_SPACE_ROWS);
    float across = length(s.dir.xy);
    float r = planet.x + space_eye.x;
    if (s.disc >= 0.0) {
        float e = atan(sqrt(s.disc), r * across);
        return (0.5 + sqrt(e * (2.0 / PI)) * (LIMB - 1.0)) / ROWS;
    }
    if (s.dir.z <= 0.0) {
        float least = -s.disc / (planet.x + sqrt(planet.x * planet.x - s.disc));
        float x = sqrt(min(least / space_eye.w, 1.0));
        // Within the air sights that are all but level differ most.
        x = space_eye.x < planet.y - planet.x ? 1.0 - sqrt(1.0 - x) : x;
        return (LIMB + 0.5 + x * (UP - LIMB - 1.0)) / ROWS;
    }
    return (UP + 0.5 + sqrt(atan(s.dir.z, across) * (2.0 / PI)) * (ROWS - UP - 1.0)) / ROWS;
}

float space_column(int light, vec3 dir)
{
    vec2 to = space_lights[light].xy;
    float c = dot(dir.xy, to) * inversesqrt(max(dot(dir.xy, dir.xy) * dot(to, to), 1e-20));
    float x = sqrt(fast_acos(clamp(c, -1.0, 1.0)) / PI);
    return (0.5 + x * float(PEL_SPACE_COLUMNS - 1)) / float(PEL_SPACE_COLUMNS);
}

// Light that the air adds along a sight, as far as the ground or out of it, and
// what comes through.
vec3 space_air(space_sight s, out vec3 through)
{
    float least = -s.disc / (planet.x + sqrt(max(planet.x * planet.x - s.disc, 0.0)));
    bool beside = s.disc < 0.0 && (s.dir.z > 0.0 ? space_eye.x >= planet.y - planet.x
                                                 : least >= planet.y - planet.x);
    through = vec3(1.0);
    if (beside || water.w > 0.5) {
        return vec3(0.0);
    }
    float row = space_row(s);
    through = exp2(textureLod(space_throughs, vec2(0.5, row), 0.0).rgb);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        sum += exp2(textureLod(space_airs, vec3(space_column(i, s.dir), row, i), 0.0).rgb);
    }
    // Ours ends at its top at once; long exposures of twilight would show an edge.
    float below = planet.y - planet.x - least;
    return s.disc < 0.0 && space_eye.x > planet.y - planet.x ? sum * smoothstep(0.0, 6000.0, below) : sum;
}

// --- a point of the ground -------------------------------------------------------

// Its frame is the eye's, turned by the shortest way until z is its normal, so
// that nothing turns at poles or date line.
struct space_point {
    vec2 away;       // azimuth from the nadir
    float sine, cosine; // of the normal's angle from the eye's
    vec2 x;          // on the map, m from the nadir
    float range;     // m from the eye
    vec3 earth;      // its normal in the Earth's axes
};

vec3 into_point(space_point p, vec3 v)
{
    float u = dot(v.xy, p.away), side = p.away.x * v.y - p.away.y * v.x;
    float level = u * p.cosine - v.z * p.sine;
    return vec3(p.away * level + vec2(-p.away.y, p.away.x) * side, u * p.sine + v.z * p.cosine);
}

vec3 out_of_point(space_point p, vec3 v)
{
    float u = dot(v.xy, p.away), side = p.away.x * v.y - p.away.y * v.x;
    float level = u * p.cosine + v.z * p.sine;
    return vec3(p.away * level + vec2(-p.away.y, p.away.x) * side, v.z * p.cosine - u * p.sine);
}

// Over x, for x of 0 to 1.
float arc_over_sine(float x)
{
    float x2 = x * x;
    return x < 0.4 ? 1.0 + x2 * (1.0 / 6.0 + x2 * (3.0 / 40.0 + x2 * (15.0 / 336.0 + x2 * (105.0 / 3456.0))))
                   : atan(x, sqrt(max(1.0 - x2, 0.0))) / x;
}

space_point point_of(vec3 dir, space_sight s)
{
    space_point p;
    float t = sight_length(s);
    p.range = t / s.longer;
    vec2 off = s.dir.xy * (t / planet.x);
    float sine2 = min(dot(off, off), 1.0);
    vec3 n = normalize(out_of_sphere(vec3(off, sqrt(1.0 - sine2))));
    p.sine = length(n.xy);
    p.cosine = n.z;
    float level = length(dir.xy);
    p.away = p.sine > 1e-7 ? n.xy / p.sine : level > 1e-7 ? dir.xy / level : vec2(1.0, 0.0);
    p.x = dir.xy * (p.range * arc_over_sine(sqrt(sine2)));
    p.earth = n.x * space_earth[0].xyz + n.y * space_earth[1].xyz + n.z * space_earth[2].xyz;
    return p;
}

// --- its light --------------------------------------------------------------------

layout(binding = PEL_UNIT_SPACE_SKIES) uniform sampler2DArray space_skies_map;
layout(binding = PEL_UNIT_SPACE_WATERS) uniform sampler2DArray space_waters;
layout(binding = PEL_UNIT_SPACE_SECONDS) uniform sampler2DArray space_seconds;

// Of each light at the point: where it stands, its beam, its sky's irradiance.
vec3 space_to[PEL_LIT], space_beams[PEL_LIT];
vec4 space_sky_light[PEL_LIT];
// The layers around its elevation: the first of them, by how much more of the
// light of the sky, and of all, the point has than each, times its weight.
struct space_layers {
    vec2 turn; // azimuth of the light
    float layer;
    vec3 sky0, sky1, all0, all1;
};
space_layers space_at[PEL_LIT];

#define skies space_sky_light

vec3 beam_there(int i)
{
    return space_beams[i];
}

vec3 light_above(int i, vec2 tilt)
{
    return space_to[i];
}

void light_point(sampler2D transmittance, space_point p)
{
    const float LAST = float(PEL_SPACE_SUNS - 1);
    for (int i = 0; i < PEL_LIT; i++) {
        vec3 to = into_point(p, lights[i].direction.xyz);
        float level = length(to.xy);
        float elevation = mix(space_lights[i].w, atan(to.z, level), space_eye.z);
        float u = (elevation + PEL_SPACE_SUN_MIDDLE) / PEL_SPACE_SUN_WIDTH;
        float place = (log(u + sqrt(u * u + 1.0)) - PEL_SPACE_SUN_FIRST) /
                      (PEL_SPACE_SUN_LAST - PEL_SPACE_SUN_FIRST) * LAST;
        float layer = clamp(floor(place), 0.0, LAST - 1.0);
        float f = clamp(place - layer, 0.0, 1.0);
        int k = 2 * int(layer);
        vec3 sky = space_suns[k].rgb, sky_rise = space_suns[k + 2].rgb - sky;
        vec3 all = space_suns[k + 1].rgb, all_rise = space_suns[k + 3].rgb - all;
        // Deep night has nothing.
        vec3 given = lights[i].irradiance.rgb / space_sun.rgb *
                     exp(min((elevation + radians(20.0)) / radians(2.5), 0.0));
        space_at[i].turn = level > 1e-6 ? to.xy / level : vec2(1.0, 0.0);
        space_at[i].layer = layer;
        space_at[i].sky0 = given * exp2(f * sky_rise) * (1.0 - f);
        space_at[i].sky1 = given * exp2((f - 1.0) * sky_rise) * f;
        space_at[i].all0 = given * exp2(f * all_rise) * (1.0 - f);
        space_at[i].all1 = given * exp2((f - 1.0) * all_rise) * f;
        space_to[i] = to;
        space_beams[i] = lights[i].irradiance.rgb *
                         light_transmittance(transmittance, 0.0, sin(elevation), lights[i].direction.w);
        space_sky_light[i] = vec4(given * exp2(sky + f * sky_rise), 0.0);
    }
}

vec2 from_light(int i, vec2 v)
{
    vec2 t = space_at[i].turn;
    return vec2(dot(v, t), t.x * v.y - t.y * v.x);
}

// The mirrored sky at a place of the stereographic map, its half width 1.
vec3 space_sky(vec2 place, float lod)
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        vec3 at = vec3(from_light(i, place) * (0.5 / PEL_REFLECTION_HALF_WIDTH) + 0.5, space_at[i].layer);
        sum += textureLod(space_skies_map, at, lod).rgb * space_at[i].sky0;
        at.z += 1.0;
        sum += textureLod(space_skies_map, at, lod).rgb * space_at[i].sky1;
    }
    return sum;
}

vec4 space_second(vec2 away, float radius)
{
    vec4 sum = vec4(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        vec3 at = vec3(0.5 + 0.5 * radius * from_light(i, away), space_at[i].layer);
        vec4 near = textureLod(space_seconds, at, 0.0);
        at.z += 1.0;
        vec4 next = textureLod(space_seconds, at, 0.0);
        sum.rgb += near.rgb * space_at[i].sky0 + next.rgb * space_at[i].sky1;
        sum.a = i == PEL_LIGHT_FIRST ? 0.5 * (near.a + next.a) : sum.a;
    }
    return sum;
}

// leaving_deep_water of the point.
vec3 space_leaving(int i, vec2 place)
{
    vec3 at = vec3(place, space_at[i].layer);
    vec3 sum = textureLod(space_waters, at, 0.0).rgb * space_at[i].all0;
    at.z += 1.0;
    return sum + textureLod(space_waters, at, 0.0).rgb * space_at[i].all1;
}
