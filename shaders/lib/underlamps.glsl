// Lamps in the water (render/lampglow.h has the form of each): what they light,
// and their beams, which water scatters once to the eye.
#include "lib/lamptowards.glsl"
#ifdef PEL_LAMPS_BELOW

vec4 under_lamp(int lamp, int i)
{
    return under_lamps[PEL_GLOW_TEXELS * lamp + i];
}

// At a place, from the eye: irradiance across the way to the lamp, by Beer's law,
// and the unit direction to it.
vec3 under_lamp_falling(int lamp, vec3 place, out vec3 to)
{
    vec4 light = under_lamp(lamp, 1);
    vec3 way = under_lamp(lamp, 0).xyz - place;
    float away2 = max(dot(way, way), 1e-4);
    to = way * inversesqrt(away2);
    return light.rgb * under_left(sqrt(away2)) *
           (lamp_towards(-to, light, under_lamp(lamp, 2), under_lamp(lamp, 3), under_lamp(lamp, 4).x) / away2);
}

int under_lamp_count()
{
    return int(under_lens.y);
}

vec3 under_lamps_on_face(vec3 place, vec3 n)
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < under_lamp_count(); i++) {
        vec3 to;
        vec3 beam = under_lamp_falling(i, place, to);
        sum += beam * max(dot(n, to), 0.0);
    }
    return sum;
}

// Where a sight is in the cone in which a beam has a 500th of its strength; where
// it leaves the lamp's side, too.
vec2 beam_reach(int lamp, vec3 sight, float s)
{
    float half_ = 3.0 * under_lamp(lamp, 1).w;
    if (half_ <= 0.0 || half_ > 1.4) {
        return vec2(0.0, s);
    }
    vec3 o = -under_lamp(lamp, 0).xyz, axis = under_lamp(lamp, 2).xyz;
    float c = cos(half_), k = c * c, a = dot(axis, sight), b = dot(axis, o), e = dot(o, sight);
    float p = a * a - k, q = a * b - k * e, r = b * b - k * dot(o, o);
    float root = sqrt(max(q * q - p * r, 0.0));
    float t1 = clamp((-q - root) / p, 0.0, s), t2 = clamp((-q + root) / p, 0.0, s);
    vec3 ends = vec3(min(t1, t2), max(t1, t2), s);
    vec2 range = vec2(s, 0.0);
    float from = 0.0;
    for (int i = 0; i < 3; i++) {
        vec3 middle = o + sight * (0.5 * (from + ends[i]));
        bool inside = ends[i] > from && dot(middle, axis) > c * length(middle);
        range = inside ? vec2(min(range.x, from), max(range.y, ends[i])) : range;
        from = ends[i];
    }
    return range;
}

// Of one lamp on s m: the places are at even angles as the lamp sees them, so that
// its inverse square is in their weights (Kulla and Fajardo 2012).
vec3 lamp_between(int lamp, vec3 sight, float s)
{
    const int PLACES = 28;
    vec2 range = beam_reach(lamp, sight, s);
    vec3 at = under_lamp(lamp, 0).xyz;
    float nearest = dot(at, sight);
    float off = max(length(at - nearest * sight), 1e-2);
    float first = atan((range.x - nearest) / off), last = atan((range.y - nearest) / off);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < PLACES; i++) {
        float angle = mix(first, last, (float(i) + 0.5) / float(PLACES));
        float t = nearest + off * tan(angle);
        vec3 to;
        vec3 beam = under_lamp_falling(lamp, t * sight, to);
        float away2 = (t - nearest) * (t - nearest) + off * off;
        sum += beam * under_left(t) * under_phase(dot(to, sight)) * away2;
    }
    return range.y > range.x ? under_scatter.rgb * sum * ((last - first) / (float(PLACES) * off)) : vec3(0.0);
}

vec3 under_lamps_between(vec3 sight, float s)
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < under_lamp_count(); i++) {
        sum += lamp_between(i, sight, min(s, 200.0));
    }
    return sum;
}
#endif
