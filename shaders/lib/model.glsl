// Models of entities as the shaders read them (render/objects.h).

layout(binding = PEL_UNIT_OBJECT_VERTICES) uniform samplerBuffer object_vertices;
layout(binding = PEL_UNIT_OBJECT_TRIANGLES) uniform usamplerBuffer object_triangles; // corners, material
layout(binding = PEL_UNIT_OBJECT_PLACES) uniform samplerBuffer object_places;
layout(binding = PEL_UNIT_OBJECT_HULLS) uniform sampler2DArray object_hulls;

// One of the PEL_OBJECT_PLACE_TEXELS of an entity. A program for tiles near one
// alone has them as uniforms, which software devices read once for all pixels.
#ifdef PEL_ONE_OBJECT
layout(location = PEL_UNIFORM_PLACE) uniform vec4 one_place[PEL_OBJECT_PLACE_TEXELS];
#endif
vec4 place_texel(int i, int k)
{
#ifdef PEL_ONE_OBJECT
    return one_place[k];
#else
    return texelFetch(object_places, i * PEL_OBJECT_PLACE_TEXELS + k);
#endif
}

// An entity in this view: the model's axes in the world, its origin from the
// eye's nadir and above the sea's zero.
struct placed {
    vec3 x, y, z, origin;
};

placed placed_object(int i)
{
    vec4 x = place_texel(i, 0);
    vec4 y = place_texel(i, 1);
    vec4 z = place_texel(i, 2);
    return placed(x.xyz, y.xyz, z.xyz, vec3(x.w, y.w, z.w));
}

// Its number, class, hull's layer or -1, shadow's layer or -1.
vec4 object_facts(int i)
{
    return place_texel(i, 3);
}

// The square of half the arc over the Earth's radius.
float half_arc2(vec2 level)
{
    return dot(level, level) * (0.25 / (planet.x * planet.x));
}

// From the eye, over the same sphere as the sea's mesh; within 100 km two terms
// of the sine are as good as a float.
vec3 over_sphere(vec3 level)
{
    float a2 = half_arc2(level.xy);
    return vec3(level.xy * (1.0 - 0.5 * a2),
                level.z - 2.0 * planet.x * a2 * (1.0 - a2 * (1.0 / 3.0)) - eye.x);
}

vec3 object_point(placed o, vec3 p)
{
    return over_sphere(o.origin + o.x * p.x + o.y * p.y + o.z * p.z);
}

// From the object's origin in the axes of the world, of a point from the eye.
vec3 from_object(placed o, vec3 p)
{
    float a2 = half_arc2(p.xy);
    vec3 level = vec3(p.xy * (1.0 + 0.5 * a2), p.z + eye.x + 2.0 * planet.x * a2);
    return level - o.origin;
}

// In the model's axes.
vec3 into_model(placed o, vec3 p)
{
    vec3 d = from_object(o, p);
    return vec3(dot(d, o.x), dot(d, o.y), dot(d, o.z));
}

// How a point, in the model's axes, lies to its hull: 2 above its lowest surface,
// 1 so within the texels that its outline or a steep side crosses, else 0.
int in_hull(int i, vec3 m)
{
    float layer = object_facts(i).z;
    vec4 plan = place_texel(i, 4);
    vec2 uv = (m.xy - plan.xy) * plan.zw;
    vec2 inside = step(vec2(0.0), uv) * step(uv, vec2(1.0));
    vec4 low = textureGather(object_hulls, vec3(uv, layer));
    float least = min(min(low.x, low.y), min(low.z, low.w));
    float most = max(max(low.x, low.y), max(low.z, low.w));
    return inside.x * inside.y == 0.0 || m.z <= least ? 0 : m.z > most ? 2 : 1;
}

// Whether the sea at `sea`, from the eye, is to be left out before the object
// at `seen`, of which the ray meets the `inner` side: water in the boat. Where
// the hull's texels are too coarse its outer side keeps the sea: what is close
// behind is the wall that the sea touches.
bool hull_keeps_dry(int i, vec3 sea, vec3 seen, bool inner)
{
    placed o = placed_object(i);
    vec3 water = into_model(o, sea);
    vec3 wall = into_model(o, seen);
    int at_sea = in_hull(i, water);
    vec4 plan = place_texel(i, 4);
    vec2 apart = (wall.xy - water.xy) * plan.zw * vec2(PEL_HULL_LENGTH, PEL_HULL_BREADTH);
    bool beside = inner ? dot(apart, apart) < 16.0 : in_hull(i, wall - vec3(0.0, 0.0, 0.02)) == 2;
    return at_sea == 2 || (at_sea == 1 && beside);
}
