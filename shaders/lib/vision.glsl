// How an eye sees by little light: twin of server/optics/vision.c.

float eye_cones(float photopic, float scotopic)
{
    float m = 0.5;
    for (int i = 0; i < PEL_EYE_STEPS; i++) {
        float q = m + (1.0 - m) * PEL_EYE_RODS;
        float w = m / q;
        float l = max(mix(scotopic, photopic, w), 1e-9);
        float slope = PEL_EYE_SLOPE * 0.43429 * PEL_EYE_RODS * (photopic - scotopic) / (q * q * l);
        float off = PEL_EYE_OFFSET + PEL_EYE_SLOPE * 0.30103 * log2(l) - m;
        m = clamp(m + off / max(1.0 - slope, 0.5), 0.0, 1.0);
    }
    return m / (m + (1.0 - m) * PEL_EYE_RODS);
}

// Of linear Rec. 709, cd/m², and scotopic luminance: the light as it is seen.
vec3 eye_seen(vec3 linear, float scotopic)
{
    float s = max(scotopic, 0.0);
    float w = eye_cones(dot(linear, vec3(0.2126, 0.7152, 0.0722)), s);
    return linear * w + vec3(PEL_EYE_RED, PEL_EYE_GREEN, PEL_EYE_BLUE) * (s * (1.0 - w));
}

// Twin of pel_vision_sight, of log2 of the luminance.
float eye_sight(float adapted)
{
    float l = max(adapted * 0.30103, -9.0);
    float bent = pow(max(0.405 * l + 1.6, 0.0), 2.18) - 2.86;
    float threshold = l <= -3.94 ? -2.86 : l >= -1.44 ? l - 0.395 : bent;
    return exp2(min(l - threshold - 0.395, 0.0) / 0.30103);
}

// Twin of pel_vision_blur, of log2 of the luminance.
float eye_blur(float adapted)
{
    float l = max(adapted, PEL_ACUITY_LEAST) * 0.30103;
    float finest = PEL_ACUITY_SPAN * atan(PEL_ACUITY_STEEP * l + PEL_ACUITY_OFF) + PEL_ACUITY_MIDDLE;
    float lost = 1.0 / (finest * finest) - 1.0 / (PEL_ACUITY_DAY * PEL_ACUITY_DAY);
    return PEL_ACUITY_HALF * sqrt(max(lost, 0.0));
}
