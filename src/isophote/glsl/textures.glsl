struct Where { vec3 own; vec2 uv; vec3 world; };

uint stirred(uint x) {
    x ^= x >> 16;
    x *= 0x7FEB352Du;
    x ^= x >> 15;
    x *= 0x846CA68Bu;
    return x ^ (x >> 16);
}

uint latticeKey(ivec3 cell, uint seed) {
    uint key = stirred((uint(cell.z) * 0xCB1AB31Fu) ^ seed);
    key = stirred((uint(cell.y) * 0xD8163841u) ^ key);
    return stirred((uint(cell.x) * 0x8DA6B343u) ^ key);
}

float unitOf(uint key) { return float(key >> 8) * (1.0 / 16777216.0); }

vec3 edgeVector(uint key) {
    uint h = key >> 28;
    float a = (h & 1u) == 0u ? 1.0 : -1.0;
    float b = (h & 2u) == 0u ? 1.0 : -1.0;
    if (h < 4u || h == 12u) return vec3(a, b, 0.0);
    if (h < 8u) return vec3(a, 0.0, b);
    if (h == 14u) return vec3(b, a, 0.0);
    return vec3(0.0, a, b);
}

vec3 quintic(vec3 t) { return ((t * t) * t) * (t * (t * 6.0 - 15.0) + 10.0); }

float valueNoise(vec3 p, uint seed) {
    vec3 below = floor(p), w = quintic(p - below);
    ivec3 cell = ivec3(below);
    float v[8];
    for (int k = 0; k < 8; k++) v[k] = unitOf(latticeKey(cell + ivec3(k & 1, (k >> 1) & 1, k >> 2), seed));
    vec4 x = mix(vec4(v[0], v[2], v[4], v[6]), vec4(v[1], v[3], v[5], v[7]), w.x);
    vec2 y = mix(x.xz, x.yw, w.y);
    return mix(y.x, y.y, w.z);
}

float perlinNoise(vec3 p, uint seed) {
    vec3 below = floor(p), t = p - below, w = quintic(t);
    ivec3 cell = ivec3(below);
    float v[8];
    for (int k = 0; k < 8; k++) {
        ivec3 corner = ivec3(k & 1, (k >> 1) & 1, k >> 2);
        v[k] = dot(edgeVector(latticeKey(cell + corner, seed)), t - vec3(corner));
    }
    vec4 x = mix(vec4(v[0], v[2], v[4], v[6]), vec4(v[1], v[3], v[5], v[7]), w.x);
    vec2 y = mix(x.xz, x.yw, w.y);
    return clamp(0.5 + 0.5 * mix(y.x, y.y, w.z), 0.0, 1.0);
}

float simplexBump(ivec3 cell, uint seed, vec3 d) {
    float t = max(0.5 - dot(d, d), 0.0);
    return t * t * t * t * dot(edgeVector(latticeKey(cell, seed)), d);
}

float simplexNoise(vec3 p, uint seed) {
    vec3 below = floor(p), t = p - below;
    ivec3 cell = ivec3(below);
    int total = cell.x + cell.y + cell.z;
    int thirds = total / 3, rest = total - 3 * thirds;
    if (rest < 0) { rest += 3; thirds -= 1; }
    vec3 step0 = floor(t + (t.x + t.y + t.z + float(rest)) / 3.0);
    cell += ivec3(thirds) + ivec3(step0);
    t += (step0.x + step0.y + step0.z + float(rest)) / 6.0 - step0;
    vec3 first = vec3(t.x >= t.y && t.x >= t.z, t.y > t.x && t.y >= t.z, 0.0);
    first.z = 1.0 - first.x - first.y;
    vec3 least = vec3(t.x < t.y && t.x < t.z, t.y <= t.x && t.y < t.z, 0.0);
    least.z = 1.0 - least.x - least.y;
    vec3 second = 1.0 - least;
    float n = simplexBump(cell, seed, t);
    n += simplexBump(cell + ivec3(first), seed, t - first + 1.0 / 6.0);
    n += simplexBump(cell + ivec3(second), seed, t - second + 2.0 / 6.0);
    n += simplexBump(cell + ivec3(1), seed, t - 0.5);
    return clamp(0.5 + 0.5 * (76.8 * n), 0.0, 1.0);
}

float lengthBy(int metric, vec3 d) {
    vec3 a = abs(d);
    return metric == 0 ? length(d) : (metric == 1 ? a.x + a.y + a.z : max(a.x, max(a.y, a.z)));
}

// Nearest, second nearest, and the nearest one's number. Points further than two cells off are never the nearest.
vec3 worleyNoise(vec3 p, uint seed, int metric, float jitter) {
    vec3 below = floor(p), t = p - below;
    ivec3 cell = ivec3(below);
    vec3 found = vec3(1.0e30, 1.0e30, 0.0);
    for (int i = -2; i <= 2; i++) for (int j = -2; j <= 2; j++) for (int k = -2; k <= 2; k++) {
        uint x = latticeKey(cell + ivec3(i, j, k), seed);
        uint y = stirred(x + 0x9E3779B9u), z = stirred(y + 0x9E3779B9u);
        vec3 within = (0.5 - 0.5 * jitter) + jitter * vec3(unitOf(x), unitOf(y), unitOf(z));
        float d = lengthBy(metric, vec3(i, j, k) + within - t);
        if (d < found.x) found = vec3(d, found.x, unitOf(stirred(z + 0x9E3779B9u)));
        else if (d < found.y) found.y = d;
    }
    return found;
}

float wave(int profile, float x, float share) {
    x -= floor(x);
    if (profile == 0) return 0.5 + 0.5 * sin(6.28318531 * x);
    if (profile == 1) return x;
    if (profile == 2) return 1.0 - abs(2.0 * x - 1.0);
    return x < share ? 1.0 : 0.0;
}

float coordinate(int shape, vec3 p, vec3 axis, vec3 across, vec3 around) {
    float x = dot(p, across), y = dot(p, around);
    if (shape == 0) return dot(p, axis);
    if (shape == 1) return length(vec2(x, y));
    if (shape == 2) return length(p);
    float turns = atan(y, x) / 6.28318531;
    return turns < 0.0 ? turns + 1.0 : turns;
}

float octave(int kind, float number) {
    float n = 2.0 * number - 1.0;
    return kind == 0 ? n : (kind == 1 ? abs(n) : (1.0 - abs(n)) * (1.0 - abs(n)));
}
