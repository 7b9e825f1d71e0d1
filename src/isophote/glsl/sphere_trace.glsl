// Sphere tracing of one field above a ground, as kernels/trace/sphere_*.py do it.

const int MAX_STEPS = 512;
const float PI = 3.14159265358979;
const float FAR = 1e30;

uniform vec2 size;
uniform int samples;
uniform vec3 eye, cameraRight, cameraUp, cameraBack;
uniform float halfHeight;

out vec4 pixel;

// How far the surface certainly is from p.
float clearance(vec3 p) { return field(p) / LIPSCHITZ; }

float distanceToBox(vec3 p) { return length(max(max(BOX_LOW - p, p - BOX_HIGH), 0.0)); }

// Where a ray is within the box that holds the field; near > far where it is not.
vec2 reach(vec3 o, vec3 d) {
    vec3 inverse = 1.0 / mix(d, vec3(1e-30), equal(d, vec3(0.0)));
    vec3 a = (BOX_LOW - o) * inverse, b = (BOX_HIGH - o) * inverse;
    vec3 first = min(a, b), last = max(a, b);
    return vec2(max(max(first.x, max(first.y, first.z)), 0.0), min(last.x, min(last.y, last.z)));
}

// Where a ray first meets the field, or -1. Steps are no shorter than a sixteenth of the pixel's width there; `growth` is
// how much wider a quarter of it gets along the way.
float march(vec3 o, vec3 d, float growth) {
    vec2 span = reach(o, d);
    float t = span.x;
    for (int i = 0; i < MAX_STEPS && t < span.y; ++i) {
        float h = clearance(o + d * t);
        if (h <= SURFACE) {
            for (int k = 0; k < 4; ++k) t += clearance(o + d * t);
            return t;
        }
        t += max(h, 0.25 * growth * t);
    }
    return -1.0;
}

vec3 normalAt(vec3 p) {
    const vec2 e = vec2(1.0, -1.0) * NORMAL_STEP;
    return normalize(e.xyy * field(p + e.xyy) + e.yyx * field(p + e.yyx) + e.yxy * field(p + e.yxy) + e.xxx * field(p + e.xxx));
}

// What is left of a light at a distance, seen under an angle of half width atan(width).
float lit(vec3 p, vec3 d, float far, float width) {
    float light = 1.0, t = DETAIL / 256.0, before = FAR, last = 0.0;
    float end = min(far, 4.0 * (SIDE + distanceToBox(p)));
    for (int i = 0; i < MAX_STEPS && t < end; ++i) {
        vec3 q = p + d * t;
        float away = distanceToBox(q);
        if (away > 0.0 && away >= width * light * t) {
            t += max(away, 0.01 * t);
            before = FAR;
            continue;
        }
        // The value itself is the best guess of the distance; only steps must be proven.
        float h = field(q);
        if (h <= 0.0) return 0.0;
        // The nearest approach lies behind, where the last sphere and this one meet; where the field rises that was told
        // by the last step.
        float y = h < before && before < FAR ? clamp((last * last + (h * h - before * before)) / (2.0 * last), 0.0, min(h, last)) : 0.0;
        light = min(light, sqrt(max(h * h - y * y, 0.0)) / (width * (t - y)));
        if (light <= 1e-3) return 0.0;
        // Where the light may be dimmed more, rays go slower, or shadows show their steps as bands.
        float step = h / max(LIPSCHITZ, 1.0);
        last = max(h > min(before, 2.0 * width * t) ? step : 0.5 * step, 0.01 * t);
        before = h;
        t += last;
    }
    return light;
}

// Share of the sky that is seen, from a few values along the normal.
float open(vec3 p, vec3 n) {
    float seen = 1.0, weight = 1.0;
    for (int i = 1; i <= 5; ++i) {
        float h = OCCLUSION * float(i) / 5.0;
        vec3 q = p + n * h;
        weight *= 0.5;
        float value = distanceToBox(q) < h ? field(q) : h;
        seen -= weight / (1.0 - 1.0 / 32.0) * clamp((h - value) / h, 0.0, 1.0);
    }
    return seen;
}

vec3 shade(vec3 p, vec3 n, vec3 albedo) {
    vec3 light = SKY * open(p, n);
    vec3 way = KEY_PLACE - p;
    float far = length(way);
    vec3 d = way / far;
    float cosine = dot(n, d), faces = max(dot(KEY_FACING, -d), 0.0);
    if (cosine > 0.0 && faces > 0.0)
        light += KEY_INTENSITY * (faces / (far * far) * cosine / PI) * lit(p + n * SURFACE, d, far, KEY_RADIUS * sqrt(faces) / far);
    return albedo * light;
}

vec3 radiance(vec3 d, float growth) {
    float t = march(eye, d, growth);
    float down = d.y != 0.0 ? (GROUND.y - eye.y) / d.y : -1.0;
    vec3 place = eye + d * down;
    bool ground = down > 0.0 && all(lessThan(abs(place.xz - GROUND.xz), vec2(GROUND_REACH)));
    if (t >= 0.0 && !(ground && down < t)) {
        vec3 p = eye + d * t, n = normalAt(p);
        return shade(p, dot(n, d) < 0.0 ? n : -n, ALBEDO);
    }
    return ground ? shade(place, vec3(0.0, d.y < 0.0 ? 1.0 : -1.0, 0.0), GROUND_ALBEDO) : SKY;
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
        vec3 d = place.x * cameraRight + place.y * cameraUp - cameraBack;
        float far = length(d);
        total += radiance(d / far, 0.25 * scale / far);
    }
    pixel = vec4(encoded(total / float(samples * samples)), 1.0);
}
