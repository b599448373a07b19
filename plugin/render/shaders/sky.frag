#version 330 core
// A clear sky: pale at the horizon, deeper above; a soft glow about the sun.
in vec2 screen;
out vec4 color;
uniform mat4 to_world;  // clip space -> world axes about the eye
uniform vec3 up;
uniform vec3 to_sun;
uniform vec3 horizon_color;
uniform vec3 zenith_color;
void main() {
    vec4 p = to_world * vec4(screen, 1.0, 1.0);
    vec3 direction = normalize(p.xyz / p.w);
    float height = max(0.0, dot(direction, up));
    vec3 sky = mix(horizon_color, zenith_color, 1.0 - exp(-3.0 * height));
    float glow = pow(max(0.0, dot(direction, to_sun)), 24.0);
    sky += 0.25 * glow * vec3(1.0, 0.85, 0.6);
    color = vec4(pow(sky, vec3(1.0 / 2.2)), 1.0);
}
