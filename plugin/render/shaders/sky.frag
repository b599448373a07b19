#version 330 core
// The sky, drawn at the far plane: where the depth says that nothing is seen.
in vec2 screen;
out vec4 color;  // alpha: that of no face
uniform vec3 ray, ray_x, ray_y;  // from the eye through the middle of the picture, 1 m deep; how it moves across the picture
uniform vec3 up;
uniform vec3 to_sun;
uniform vec3 horizon_color;
uniform vec3 zenith_color;
void main() {
    vec3 direction = normalize(ray + screen.x * ray_x + screen.y * ray_y);
    float height = max(0.0, dot(direction, up));
    vec3 clear = mix(horizon_color, zenith_color, 1.0 - exp(-3.0 * height));
    vec3 glow = 0.25 * pow(max(0.0, dot(direction, to_sun)), 24.0) * vec3(1.0, 0.85, 0.6);
    color = vec4(pow(clear + glow, vec3(1.0 / 2.2)), 1.0);
}
