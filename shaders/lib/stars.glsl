// Stars and planets of the pixel: each one's irradiance by a quadratic spline
// over three pixels each way, whose weights add up to 1 wherever it stands.
layout(std430, binding = PEL_STORE_STARS) restrict readonly buffer stars_block { vec4 star_words[]; };

float star_weight(float off)
{
    float d = abs(off), outer = max(1.5 - d, 0.0);
    return d < 0.5 ? 0.75 - d * d : 0.5 * outer * outer;
}

// x: the first of the words of the pixel's tile; y: its stars.
vec4 stars_of(ivec2 at)
{
    ivec2 tile = at / PEL_STAR_TILE;
    int across = (int(size.x) + PEL_STAR_TILE - 1) / PEL_STAR_TILE;
    return star_words[tile.y * across + tile.x];
}

vec3 stars_at(ivec2 at, vec4 head, float inverse)
{
    vec2 place = lattice(at);
    vec3 sum = vec3(0.0);
    int first = int(head.x);
    for (int i = 0; i < int(head.y); i++) {
        vec2 off = place - star_words[first + 2 * i].xy;
        sum += star_words[first + 2 * i + 1].rgb * (star_weight(off.x) * star_weight(off.y));
    }
    // Over the pixel's solid angle.
    return sum / (pixel.x * pixel.y * inverse * inverse * inverse);
}
