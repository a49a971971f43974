// Shows a baked level in fog. ?folder=FOLDER/ names another folder of files; the arrow keys turn the camera.
import * as THREE from 'three';
import { createFogPass, loadLevel } from './level.js';

const parameters = new URLSearchParams(location.search);
const renderer = new THREE.WebGLRenderer({ canvas: document.querySelector('canvas') });
const exposure = parameters.get('exposure') ?? 0;

const float = { type: THREE.FloatType, colorSpace: THREE.NoColorSpace };

/** Radiance to sRGB, after an exposure in stops. */
function createDisplay() {
    const material = new THREE.RawShaderMaterial({
        glslVersion: THREE.GLSL3,
        depthTest: false,
        uniforms: { image: { value: null }, gain: { value: 2 ** exposure } },
        vertexShader: 'in vec3 position; out vec2 uv; void main() { uv = 0.5 * position.xy + 0.5; gl_Position = vec4(position.xy, 0.0, 1.0); }',
        fragmentShader: `precision highp float;
            uniform sampler2D image; uniform float gain; in vec2 uv; out vec4 color;
            void main() {
                vec3 c = clamp(gain * texture(image, uv).rgb, 0.0, 1.0);
                color = vec4(mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)), 1.0);
            }`,
    });
    const quad = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material);
    quad.frustumCulled = false;
    const scene = new THREE.Scene().add(quad), camera = new THREE.Camera();
    return (texture) => {
        material.uniforms.image.value = texture;
        renderer.setRenderTarget(null);
        renderer.render(scene, camera);
    };
}

const level = await loadLevel(renderer, parameters.get('folder') ?? 'files/');
const scene = new THREE.Scene().add(level.scene), camera = level.camera;
const fog = createFogPass(level.fog), display = createDisplay();
let surfaces, image;

function resize(width, height) {
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    surfaces = new THREE.WebGLRenderTarget(width, height, { ...float, depthTexture: new THREE.DepthTexture(width, height, THREE.FloatType) });
    image = new THREE.WebGLRenderTarget(width, height, { ...float, depthBuffer: false });
}

function draw() {
    renderer.setRenderTarget(surfaces);
    renderer.render(scene, camera);
    fog.render(renderer, surfaces, camera, image);
    display(image.texture);
}

resize(...(parameters.get('size') ?? '640x480').split('x').map(Number));
draw();
addEventListener('keydown', ({ key }) => {
    if (key === 'ArrowLeft' || key === 'ArrowRight') camera.rotateOnWorldAxis(new THREE.Vector3(0, 1, 0), key === 'ArrowLeft' ? 0.05 : -0.05);
    if (key === 'ArrowUp' || key === 'ArrowDown') camera.rotateX(key === 'ArrowUp' ? 0.05 : -0.05);
    draw();
});

/** The picture's linear radiance, four floats a pixel, rows from the bottom; for tests. */
window.readRadiance = () => {
    const pixels = new Float32Array(4 * image.width * image.height);
    renderer.readRenderTargetPixels(image, 0, 0, image.width, image.height, pixels);
    return Array.from(pixels);
};
window.ready = true;
