// A baked level in fog: lightmaps, vertex colours and the light of the fog, from files of tyndall bake, export and fluence.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { KTX2Loader } from 'three/addons/loaders/KTX2Loader.js';
import { fogChunk } from './fog.js';

const json = async (address) => (await fetch(address)).json();

/** Lightmaps hold irradiance E: MeshBasicMaterial makes albedo E / pi of them, the radiance of a Lambertian surface. */
function light(object, lightmap, vertexScale) {
    const from = object.material;
    const material = new THREE.MeshBasicMaterial({ color: from.color, map: from.map, side: from.side, fog: false });
    if (lightmap) {
        lightmap.channel = 1; // TEXCOORD_1
        material.lightMap = lightmap;
    } else if (vertexScale) { // COLOR_0 is color_scale E
        material.vertexColors = true;
        material.color = from.color.clone().multiplyScalar(1 / (Math.PI * vertexScale));
    }
    object.material = material;
}

/** Loads the level of a folder: export.json, the glTF with vertex colours, fog.json and their textures. */
export async function loadLevel(renderer, folder) {
    const [files, fog] = await Promise.all([json(folder + 'export.json'), json(folder + 'fog.json')]);
    const ktx2 = new KTX2Loader().setTranscoderPath('').detectSupport(renderer);
    const gltf = await new GLTFLoader().loadAsync(folder + files.vertex_colors);
    const lightmaps = new Map(); // by node of the glTF
    await Promise.all(files.lightmaps.map(async ({ file, meshes }) => {
        const texture = await ktx2.loadAsync(folder + file);
        texture.minFilter = texture.magFilter = THREE.LinearFilter;
        texture.needsUpdate = true;
        for (const { node } of meshes) lightmaps.set(node, texture);
    }));
    gltf.scene.traverse((object) => {
        if (!object.isMesh) return;
        let named = object; // a node of several primitives is a group of meshes
        while (gltf.parser.associations.get(named)?.nodes === undefined && named.parent) named = named.parent;
        light(object, lightmaps.get(gltf.parser.associations.get(named)?.nodes), files.color_scale);
    });
    for (const lamp of gltf.scene.getObjectsByProperty('isLight', true)) lamp.removeFromParent(); // it is baked
    const volume = await ktx2.loadAsync(folder + fog.texture);
    volume.minFilter = volume.magFilter = THREE.LinearFilter;
    volume.wrapS = volume.wrapT = volume.wrapR = THREE.ClampToEdgeWrapping;
    volume.needsUpdate = true;
    ktx2.dispose();
    return { scene: gltf.scene, camera: gltf.cameras[0], fog: { ...fog, texture: volume } };
}

/** The pass that puts an image with depths into the fog; its picture is linear radiance. */
export function createFogPass(fog, steps = 64) {
    const material = new THREE.RawShaderMaterial({
        glslVersion: THREE.GLSL3,
        depthTest: false,
        depthWrite: false,
        uniforms: {
            fogTexture: { value: fog.texture },
            fogLower: { value: new THREE.Vector3(...fog.lower) },
            fogUpper: { value: new THREE.Vector3(...fog.upper) },
            fogSteps: { value: steps },
            image: { value: null },
            depths: { value: null },
            toWorld: { value: new THREE.Matrix4() },
            eye: { value: new THREE.Vector3() },
        },
        vertexShader: 'in vec3 position; out vec2 at; void main() { at = position.xy; gl_Position = vec4(position.xy, 0.0, 1.0); }',
        fragmentShader: `precision highp float;
            ${fogChunk}
            uniform sampler2D image, depths;
            uniform mat4 toWorld;
            uniform vec3 eye;
            in vec2 at;
            out vec4 color;
            void main() {
                vec2 uv = 0.5 * at + 0.5;
                vec4 world = toWorld * vec4(at, 2.0 * texture(depths, uv).r - 1.0, 1.0);
                vec3 ray = world.xyz / world.w - eye;
                vec4 fog = fogAlong(eye, normalize(ray), length(ray));
                color = vec4(texture(image, uv).rgb * fog.a + fog.rgb, 1.0);
            }`,
    });
    const quad = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material);
    quad.frustumCulled = false;
    const scene = new THREE.Scene().add(quad), camera = new THREE.Camera();
    return {
        render(renderer, source, view, target) {
            const u = material.uniforms;
            u.image.value = source.texture;
            u.depths.value = source.depthTexture;
            u.eye.value.setFromMatrixPosition(view.matrixWorld);
            u.toWorld.value.multiplyMatrices(view.matrixWorld, view.projectionMatrixInverse);
            renderer.setRenderTarget(target);
            renderer.render(scene, camera);
        },
    };
}
