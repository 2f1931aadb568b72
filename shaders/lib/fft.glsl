// A line of 256 complex numbers by 64 invocations: Stockham's radix-4 inverse
// transform without the factor 1/N, four packed transforms at once.
#if PEL_CASCADE_N != 256
#error "four stages of radix 4"
#endif
const int FFT_LANES = 64;

shared vec4 line_ab[PEL_CASCADE_N];
shared vec4 line_cd[PEL_CASCADE_N];

vec2 turned(vec2 a, vec2 b)
{
    return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

vec4 turned2(vec4 a, vec2 b)
{
    return vec4(turned(a.xy, b), turned(a.zw, b));
}

// i · a for both halves.
vec4 quarter(vec4 a)
{
    return vec4(-a.y, a.x, -a.w, a.z);
}

void butterfly(inout vec4 v[4])
{
    vec4 a = v[0] + v[2];
    vec4 b = v[0] - v[2];
    vec4 c = v[1] + v[3];
    vec4 d = quarter(v[1] - v[3]);
    v[0] = a + c;
    v[1] = b + d;
    v[2] = a - c;
    v[3] = b - d;
}

// In and out: element lane + 64 r of the line is ab[r], cd[r].
void transform_line(int lane, inout vec4 ab[4], inout vec4 cd[4])
{
    for (int stage = 0; stage < 4; stage++) {
        int span = 1 << (2 * stage);
        int k = lane & (span - 1);
        float angle = 6.283185307 * float(k) / float(span * 4);
        vec2 w1 = vec2(cos(angle), sin(angle));
        vec2 w2 = turned(w1, w1);
        vec2 w3 = turned(w2, w1);
        ab[1] = turned2(ab[1], w1);
        cd[1] = turned2(cd[1], w1);
        ab[2] = turned2(ab[2], w2);
        cd[2] = turned2(cd[2], w2);
        ab[3] = turned2(ab[3], w3);
        cd[3] = turned2(cd[3], w3);
        butterfly(ab);
        butterfly(cd);
        int to = (lane - k) * 4 + k;
        barrier();
        for (int r = 0; r < 4; r++) {
            line_ab[to + r * span] = ab[r];
            line_cd[to + r * span] = cd[r];
        }
        barrier();
        for (int r = 0; r < 4; r++) {
            ab[r] = line_ab[lane + r * FFT_LANES];
            cd[r] = line_cd[lane + r * FFT_LANES];
        }
    }
}
