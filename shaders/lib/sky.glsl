// The atmosphere, twin of optics/atmosphere.c: densities, the tables'
// parametrisation, integration along a ray. Heights above the ground and
// distances in metres.

const float PI = 3.14159265358979;

float rayleigh_density(float height)
{
    return exp(-height / rayleigh.w);
}

float mie_density(float height)
{
    return exp(-height / mie.z);
}

float ozone_density(float height)
{
    return max(0.0, 1.0 - abs(height - ozone.w) / planet.z);
}

vec3 extinction(float height)
{
    return rayleigh.rgb * rayleigh_density(height) + mie.x * mie_density(height) +
           ozone.rgb * ozone_density(height);
}

float rayleigh_phase(float mu)
{
    return 3.0 / (16.0 * PI) * (1.0 + mu * mu);
}

// Cornette and Shanks 1992.
float mie_phase(float mu)
{
    float g = mie.w;
    float g2 = g * g;
    return 3.0 / (8.0 * PI) * (1.0 - g2) * (1.0 + mu * mu) /
           ((2.0 + g2) * pow(1.0 + g2 - 2.0 * g * mu, 1.5));
}

// Height at distance t along a ray that starts at height h with zenith cosine
// mu; written so that no large numbers cancel.
float height_along(float h, float mu, float t)
{
    float r = planet.x + h;
    float rise = t * (t + 2.0 * r * mu); // r_t² − r²
    return h + rise / (sqrt(max(r * r + rise, 0.0)) + r);
}

// Distance to the top of the atmosphere from below it.
float distance_to_top(float h, float mu)
{
    float r = planet.x + h;
    float c = (planet.y - r) * (planet.y + r);
    return -r * mu + sqrt(max(r * r * mu * mu + c, 0.0));
}

// Distance to the ground, or −1.
float distance_to_ground(float h, float mu)
{
    float r = planet.x + h;
    float c = h * (planet.x + r);
    float disc = r * r * mu * mu - c;
    if (mu >= 0.0 || disc < 0.0) {
        return -1.0;
    }
    return c / (-r * mu + sqrt(disc));
}

float horizon_cosine(float h)
{
    float r = planet.x + h;
    return -sqrt(max(h * (planet.x + r), 0.0)) / r;
}

// Transmittance table: u from the ray's length to the top between its least
// and greatest, v from the distance to the horizon (Bruneton and Neyret 2008).
vec2 transmittance_uv(float h, float mu, vec2 table)
{
    float r = planet.x + h;
    float top = sqrt((planet.y - planet.x) * (planet.y + planet.x));
    float rho = sqrt(max(h * (planet.x + r), 0.0));
    float d_min = planet.y - r;
    float d_max = rho + top;
    float x = (distance_to_top(h, mu) - d_min) / (d_max - d_min);
    return (0.5 + vec2(x, rho / top) * (table - 1.0)) / table;
}

void transmittance_from_texel(vec2 texel, vec2 table, out float h, out float mu)
{
    vec2 x = clamp((texel - 0.5) / (table - 1.0), 0.0, 1.0);
    float top = sqrt((planet.y - planet.x) * (planet.y + planet.x));
    float rho = x.y * top;
    float r = sqrt(rho * rho + planet.x * planet.x);
    h = rho * rho / (r + planet.x);
    float d_min = planet.y - r;
    float d = d_min + x.x * (rho + top - d_min);
    mu = d <= 0.0 ? 1.0 : clamp((top * top - rho * rho - d * d) / (2.0 * r * d), -1.0, 1.0);
}

vec3 transmittance_to_top(sampler2D table, float h, float mu)
{
    return textureLod(table, transmittance_uv(h, mu, vec2(textureSize(table, 0))), 0.0).rgb;
}

// Transmittance to a light of zenith cosine mu, with the part of its disc that
// stands below the horizon left out.
vec3 light_transmittance(sampler2D table, float h, float mu, float radius)
{
    float horizon = horizon_cosine(h);
    return transmittance_to_top(table, h, max(mu, horizon)) *
           smoothstep(-1.0, 1.0, (mu - horizon) / radius);
}

// Sky table of an eye: u by azimuth from the light (0..π), finer near it, v by
// the angle from the horizon, finer near it; the lower half is below.
vec2 sky_uv(float azimuth, float angle_above, vec2 table)
{
    float x = sqrt(min(abs(angle_above) * (2.0 / PI), 1.0));
    float rows = 0.5 * table.y;
    float v = angle_above >= 0.0 ? rows + 0.5 + x * (rows - 1.0) : rows - 0.5 - x * (rows - 1.0);
    return vec2((0.5 + sqrt(azimuth / PI) * (table.x - 1.0)) / table.x, v / table.y);
}

// acos by Abramowitz and Stegun 4.4.45, |error| < 7e-5.
float fast_acos(float x)
{
    float y = abs(x);
    float p = sqrt(max(1.0 - y, 0.0)) *
              (1.5707288 + y * (-0.2121144 + y * (0.0742610 - y * 0.0187293)));
    return x < 0.0 ? PI - p : p;
}

// Light scattered before, per unit irradiance of a light (optics/airlight.h),
// at a height where molecules and aerosols have these densities, for a line of
// sight at a zenith angle and `half_turn`, the sine of half its azimuth from the
// light.
vec3 airlight_at(sampler3D table, float h, float dr, float dm, float light_mu, float zenith,
                 float half_turn)
{
    const vec3 LAST = vec3(PEL_AIR_AZIMUTHS - 1, PEL_AIR_ZENITHS - 1, PEL_AIR_SUNS - 1);
    const float ROWS = float(PEL_AIR_ZENITHS * PEL_AIR_HEIGHTS);
    float u = (0.5 * PI - fast_acos(light_mu) + PEL_AIR_SUN_MIDDLE) / PEL_AIR_SUN_WIDTH;
    vec3 at = vec3(half_turn, zenith / PI,
                   (log(u + sqrt(u * u + 1.0)) - PEL_AIR_SUN_FIRST) /
                       (PEL_AIR_SUN_LAST - PEL_AIR_SUN_FIRST));
    at = clamp(at, 0.0, 1.0) * LAST + 0.5;
    float x = PEL_AIR_SHARE_MIE * sqrt(max(1.0 - dm, 0.0)) + PEL_AIR_SHARE_RAYLEIGH * (1.0 - dr) +
              (1.0 - PEL_AIR_SHARE_MIE - PEL_AIR_SHARE_RAYLEIGH) * h / (planet.y - planet.x);
    x = clamp(x, 0.0, 1.0) * float(PEL_AIR_HEIGHTS - 1);
    float low = min(floor(x), float(PEL_AIR_HEIGHTS - 2));
    at.y += low * float(PEL_AIR_ZENITHS);
    at /= vec3(PEL_AIR_AZIMUTHS, ROWS, PEL_AIR_SUNS);
    vec3 below = textureLod(table, at, 0.0).rgb;
    at.y += 1.0 / float(PEL_AIR_HEIGHTS);
    return exp2(mix(below, textureLod(table, at, 0.0).rgb, x - low));
}

float azimuth_from(int light, vec2 dir)
{
    vec2 to = lights[light].direction.xy;
    float c = dot(dir, to) * inversesqrt(max(dot(dir, dir) * dot(to, to), 1e-20));
    return fast_acos(clamp(c, -1.0, 1.0));
}

#ifndef PEL_SPACE
// Towards a light, in the frame of a place on the sphere whose up is tilted.
vec3 light_above(int light, vec2 tilt)
{
    vec3 to = lights[light].direction.xyz;
    return normalize(vec3(to.xy - tilt * to.z, to.z + dot(tilt, to.xy)));
}
#endif

// The sky that all lights make, from a table with a layer for each.
vec3 sky_light(sampler2DArray table, vec2 dir, float angle)
{
    vec2 size = vec2(textureSize(table, 0).xy);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        sum += textureLod(table, vec3(sky_uv(azimuth_from(i, dir), angle, size), i), 0.0).rgb;
    }
    return sum;
}
