const int MAX_STEPS = 256;
const float PI = 3.14159265358979;

uniform vec2 size;
uniform int samples;
uniform vec3 eye, cameraRight, cameraUp, cameraBack;
uniform float halfHeight;

out vec4 pixel;

// How far the surface certainly is from p.
float clearance(vec3 p) { return field(p) / LIPSCHITZ; }

// Where a ray meets the field, or -1.
float march(vec3 o, vec3 d, float near, float far, float footprint) {
    float t = near;
    for (int i = 0; i < MAX_STEPS && t < far; ++i) {
        float h = clearance(o + d * t);
        if (h <= footprint * t) return t;
        t += h;
    }
    return -1.0;
}

// Where a ray crosses the sphere that holds the field; near > far where it does not.
vec2 reach(vec3 o, vec3 d) {
    vec3 c = o - CENTRE;
    float b = dot(c, d), q = RADIUS * RADIUS - (dot(c, c) - b * b);
    if (q < 0.0) return vec2(1.0, 0.0);
    return vec2(max(-b - sqrt(q), 0.0), -b + sqrt(q));
}

vec3 normalAt(vec3 p) {
    const vec2 e = vec2(1.0, -1.0) * NORMAL_STEP;
    return normalize(e.xyy * field(p + e.xyy) + e.yyx * field(p + e.yyx) + e.yxy * field(p + e.yxy) + e.xxx * field(p + e.xxx));
}

// Share of a light of size `spread` (tangent of its angle) that is seen, by the smallest clearance along the way.
float lit(vec3 p, vec3 d, float far, float spread) {
    vec2 span = reach(p, d);
    float seen = 1.0, t = max(span.x, SURFACE);
    far = min(far, span.y);
    for (int i = 0; i < MAX_STEPS && t < far; ++i) {
        float h = clearance(p + d * t);
        seen = min(seen, h / (spread * t));
        if (seen < -1.0) break;
        t += clamp(abs(h), 0.1 * spread * t + SURFACE, 0.2 * RADIUS);
    }
    seen = clamp(seen * 0.5 + 0.5, 0.0, 1.0);
    return seen * seen * (3.0 - 2.0 * seen);
}

// Share of the sky that is seen, from a few clearances along the normal.
float open(vec3 p, vec3 n) {
    float hidden = 0.0, weight = 0.5;
    for (int i = 1; i <= 5; ++i) {
        float step = OCCLUSION * float(i) / 5.0;
        hidden += weight * max(step - clearance(p + n * step), 0.0) / step;
        weight *= 0.5;
    }
    return clamp(1.0 - hidden, 0.0, 1.0);
}

vec3 shade(vec3 p, vec3 n, vec3 albedo) {
    vec3 way = KEY_PLACE - p;
    float far = length(way);
    vec3 l = way / far;
    float cosine = dot(n, l), facing = max(dot(KEY_FACING, -l), 0.0);
    vec3 light = SKY * open(p + n * SURFACE, n);
    if (cosine > 0.0 && facing > 0.0)
        light += KEY_INTENSITY * facing / (PI * far * far) * cosine * lit(p + n * SURFACE, l, far, KEY_SIZE / far);
    return albedo * light;
}

vec3 radiance(vec3 d, float footprint) {
    vec2 span = reach(eye, d);
    float t = span.x > span.y ? -1.0 : march(eye, d, span.x, span.y, footprint);
    float ground = d.y < 0.0 ? (GROUND - eye.y) / d.y : -1.0;
    if (t >= 0.0 && (ground <= 0.0 || t < ground)) {
        vec3 p = eye + d * t;
        return shade(p, normalAt(p), ALBEDO);
    }
    if (ground > 0.0 && ground < GROUND_REACH) return shade(eye + d * ground, vec3(0.0, 1.0, 0.0), GROUND_ALBEDO);
    return SKY;
}

vec3 encoded(vec3 c) {
    c = clamp(c, 0.0, 1.0);
    return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, greaterThan(c, vec3(0.0031308)));
}

void main() {
    vec3 total = vec3(0.0);
    float scale = 2.0 * halfHeight / size.y;
    for (int i = 0; i < samples * samples; ++i) {
        vec2 at = gl_FragCoord.xy - 0.5 + (vec2(i % samples, i / samples) + 0.5) / float(samples);
        vec2 place = (at - 0.5 * size) * scale;
        vec3 d = normalize(place.x * cameraRight + place.y * cameraUp - cameraBack);
        total += radiance(d, 0.5 * scale);
    }
    pixel = vec4(encoded(total / float(samples * samples)), 1.0);
}
