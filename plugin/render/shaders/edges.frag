#version 330 core
// The picture as finish.frag draws it, where it was lit once a pixel: edges between faces are smoothed by their shape (as in
// Reshetov, Morphological antialiasing, 2009). A stair of pixels is taken for a straight line from the middle of one step to the
// middle of the next, and a pixel is mixed with the one beyond by the share that lies beyond that line.
out vec4 color;
uniform sampler2D lit;  // alpha: a number for each face
const int kReach = 5;  // pixels along an edge

float face_at(ivec2 at) { return texelFetch(lit, clamp(at, ivec2(0), textureSize(lit, 0) - 1), 0).a; }

// How far an edge goes on from a pixel, and how it ends: +1/2 where the face goes on beyond the edge, -1/2 where it ends before it.
vec2 follow(ivec2 here, float own, ivec2 along, ivec2 beyond) {
    for (int i = 1; i <= kReach; ++i) {
        ivec2 at = here + i * along;
        if (face_at(at) != own) return vec2(i, -0.5);
        if (face_at(at + beyond) == own) return vec2(i, 0.5);
    }
    return vec2(kReach + 1, 0.0);
}

// Share of the pixel beyond the straight edge.
float share_beyond(ivec2 here, float own, ivec2 beyond) {
    ivec2 along = beyond.yx;
    vec2 back = follow(here, own, -along, beyond), forth = follow(here, own, along, beyond);
    float whole = back.x + forth.x - 1.0;
    if (back.y == forth.y) return max(0.0, -back.y * abs((2.0 * back.x - 1.0) / whole - 1.0));  // down and up again
    // Where the line enters the pixel and where it leaves, and the area below 0 between.
    float slope = (forth.y - back.y) / whole;
    float enters = back.y + (back.x - 1.0) * slope, leaves = enters + slope;
    float low = max(0.0, -min(enters, leaves)), high = max(0.0, -max(enters, leaves));
    return high > 0.0 ? 0.5 * (low + high) : 0.5 * low * low / abs(slope);
}

void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec4 own = texelFetch(lit, here, 0);
    // Of two neighbours in one line the first that is another face. A software GL takes all branches for all pixels: few, then.
    bool is_above = face_at(here + ivec2(0, 1)) != own.a, is_beside = face_at(here + ivec2(1, 0)) != own.a;
    bool is_below = face_at(here - ivec2(0, 1)) != own.a, is_before = face_at(here - ivec2(1, 0)) != own.a;
    ivec2 rise = ivec2(0, is_above ? 1 : -1);
    ivec2 aside = ivec2(is_beside ? 1 : -1, 0);
    vec4 above = texelFetch(lit, clamp(here + rise, ivec2(0), textureSize(lit, 0) - 1), 0);
    vec4 beside = texelFetch(lit, clamp(here + aside, ivec2(0), textureSize(lit, 0) - 1), 0);
    float above_share = is_above || is_below ? share_beyond(here, own.a, rise) : 0.0;
    float beside_share = is_beside || is_before ? share_beyond(here, own.a, aside) : 0.0;
    vec3 sum = above_share * above.rgb + beside_share * beside.rgb;
    color = vec4((1.0 - above_share - beside_share) * own.rgb + sum, 1.0);
}
