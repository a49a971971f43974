/* Scene files that are wrong: each must be refused with the right code, place, line and reason. */
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

#include <tyndall/io.h>

typedef struct bad_case {
    const char* text;
    const char* override; /* or NULL */
    const char* message;  /* whole, or its beginning when it ends in "..." */
} bad_case;

/* Line 1 is the first brace. */
#define HEAD "{\"tyndall\": 1,\n"
#define BOX "\"bounds\": [[0,0,0],[1,1,1]]"
#define MEDIUM(members) HEAD "\"media\": [\n{" members "}]}"
#define LIGHT(members) HEAD "\"lights\": [\n{" members "}]}"
#define SHAPE(members) HEAD "\"geometry\": [\n{" members "}]}"

#define DENSITY(members) MEDIUM("\"sigma_s\": 1,\n\"density\": {" members "}")
#define TRANSFER(members, points) MEDIUM(members ", " BOX ", \"density\": {\"noise\": {}},\n\"transfer\": [" points "]")
#define POINTS "{\"value\": 0, \"density\": 0, \"albedo\": 1}, {\"value\": 1, \"density\": 1, \"albedo\": 1}"

static const bad_case bad_cases[] = {
    /* syntax */
    {"", NULL, "s.json:1: '[' or '{' expected near end of file"},
    {HEAD "\"camera\": {},\n}", NULL, "s.json:3: string or '}' expected near '}'"},
    {HEAD "\"up_axis\": \"y\"} x", NULL, "s.json:2: end of file expected near 'x'"},
    {HEAD "\"up_axis\": \"y\",\n\"up_axis\": \"z\"}", NULL, "s.json:3: duplicate object key near '\"up_axis\"'"},
    {HEAD "\"meters_per_unit\": NaN}", NULL, "s.json:2: invalid token near 'NaN'"},
    {HEAD "\"meters_per_unit\": Infinity}", NULL, "s.json:2: invalid token near 'Infinity'"},
    {HEAD "\"meters_per_unit\": 1e999}", NULL, "s.json:2: real number overflow near '1e999'"},
    {HEAD "\"render\": {\"seed\": 99999999999999999999}}", NULL,
     "s.json:2: too big integer near '99999999999999999999'"},
    {HEAD "\"name\": \"\\u0000\"}", NULL, "s.json:2: \\u0000 is not allowed..."},
    {HEAD "\"a\": \"\xff\"}", NULL, "s.json:2: unable to decode byte 0xff..."},
    /* the top level */
    {"[]", NULL, "s.json:1: expected an object, found an array"},
    {"\n{}", NULL, "s.json:2: the key \"tyndall\" is missing"},
    {"{\"tyndall\": 2, \"future\": 1}", NULL, "s.json:1: tyndall: expected 1, found 2"},
    {"{\n\"tyndal\": 1}", NULL, "s.json:2: tyndal: unknown key; did you mean \"tyndall\"?"},
    {HEAD "\"zzz\": 1}", NULL, "s.json:2: zzz: unknown key; known here: \"$schema\", \"tyndall\"..."},
    {HEAD "\"meters_per_unit\": 0}", NULL, "s.json:2: meters_per_unit: 0 is outside (0, 1e+06]"},
    {HEAD "\"up_axis\":\n\"x\"}", NULL, "s.json:2: up_axis: \"x\" is not one of \"y\", \"z\""},
    {HEAD "\"lights\": {}}", NULL, "s.json:2: lights: expected an array, found an object"},
    /* camera */
    {HEAD "\"camera\": {\n\"fov_y\": \"40\"}}", NULL, "s.json:3: camera.fov_y: expected a number, found a string"},
    {HEAD "\"camera\": {\"fov_y\": 180}}", NULL, "s.json:2: camera.fov_y: 180 is outside (0, 180)"},
    {HEAD "\"camera\": {\"fov\": 40}}", NULL, "s.json:2: camera.fov: unknown key; did you mean \"fov_y\"?"},
    {HEAD "\"camera\": {\"position\": [0, 1]}}", NULL, "s.json:2: camera.position: expected 3 items, found 2"},
    {HEAD "\"camera\": {\"position\": [0,\n0,\n\"5\"]}}", NULL,
     "s.json:4: camera.position[2]: expected a number, found a string"},
    {HEAD "\"camera\": {\"resolution\": [800, 600.5]}}", NULL,
     "s.json:2: camera.resolution[1]: expected an integer, found 600.5"},
    {HEAD "\"camera\": {\"resolution\": [0, 600]}}", NULL, "s.json:2: camera.resolution[0]: 0 is outside [1, 65536]"},
    {HEAD "\"camera\": {\"target\": [0, 0, 5]}}", NULL, "s.json:2: camera: position and target are the same point"},
    {HEAD "\"camera\": {\"up\": [0, 0, 1]}}", NULL, "s.json:2: camera: up points along the view..."},
    {HEAD "\"camera\": {\"up\": [0, 0, 0]}}", NULL, "s.json:2: camera.up: a direction must not be zero"},
    /* boundary */
    {HEAD "\"boundary\": {}}", NULL, "s.json:2: boundary: the key \"periodic\" is missing"},
    {HEAD "\"boundary\": {\"periodic\": [\"w\"]}}", NULL, "s.json:2: boundary.periodic[0]: ..."},
    {HEAD "\"boundary\": {\"periodic\": []}}", NULL, "s.json:2: boundary.periodic: ..."},
    {HEAD "\"boundary\": {\"periodic\": [\"x\"],\n\"cell\": [[0,0,0],[0,1,1]]}}", NULL,
     "s.json:3: boundary.cell: the second corner must be above the first along x"},
    {HEAD "\"boundary\": {\"periodic\": [\"x\"]}}", NULL,
     "s.json:2: boundary: periodic: cell: without media the cell along x must be given"},
    /* media */
    {MEDIUM("\"sigma_s\": 1,\n\"g\": 1.2"), NULL, "s.json:4: media[0].g: 1.2 is outside (-1, 1)"},
    {MEDIUM("\"sigma_s\": 1,\n\"g\": [0, -1, 0]"), NULL, "s.json:4: media[0].g[1]: -1 is outside (-1, 1)"},
    {MEDIUM("\"sigma_z\": 1"), NULL, "s.json:3: media[0].sigma_z: unknown key; did you mean \"sigma_s\"?"},
    {MEDIUM("\"sigma_s\": -1"), NULL, "s.json:3: media[0].sigma_s: -1 is outside [0, 1e+09]"},
    {MEDIUM("\"sigma_s\": [1, 2]"), NULL, "s.json:3: media[0].sigma_s: expected 3 items, found 2"},
    {MEDIUM("\"sigma_s\": \"1\""), NULL, "s.json:3: media[0].sigma_s: expected a number or an array, found a string"},
    {MEDIUM("\"sigma_t\": 1, \"albedo\": 1.5"), NULL, "s.json:3: media[0].albedo: 1.5 is outside [0, 1]"},
    {MEDIUM("\"name\": \"fog\""), NULL,
     "s.json:3: media[0]: the coefficients are missing; give sigma_s and sigma_a, or sigma_t and albedo, or preset"},
    {MEDIUM("\"sigma_t\": 1"), NULL, "s.json:3: media[0].sigma_t: the key \"albedo\" is missing beside it"},
    {MEDIUM("\n\"albedo\": 1"), NULL, "s.json:4: media[0].albedo: the key \"sigma_t\" is missing beside it"},
    {MEDIUM("\"sigma_s\": 1,\n\"albedo\": 1"), NULL,
     "s.json:4: media[0].albedo: does not go with \"sigma_s\"; give..."},
    {MEDIUM("\"sigma_a\": 1,\n\"preset\": \"apple\""), NULL,
     "s.json:4: media[0].preset: does not go with \"sigma_a\"; give..."},
    {MEDIUM("\"sigma_t\": 1, \"preset\": \"apple\""), NULL,
     "s.json:3: media[0].preset: does not go with \"sigma_t\"..."},
    {MEDIUM("\"preset\": \"hole milk\""), NULL,
     "s.json:3: media[0].preset: there is no medium \"hole milk\"; did you mean \"Wholemilk\"?"},
    {MEDIUM("\"preset\":\n\"Fog\""), NULL,
     "s.json:3: media[0].preset: Fog needs its visibility in metres, the key \"visibility\""},
    {MEDIUM("\"preset\": \"fog\",\n\"visibility\": 0"), NULL,
     "s.json:4: media[0].visibility: 0 is outside [0.001, 1e+09]"},
    {MEDIUM("\"preset\": \"jerlov ib\",\n\"dilution\": 9"), NULL,
     "s.json:4: media[0].dilution: does not go with the preset \"Jerlov IB\", only with measured media"},
    {MEDIUM("\"sigma_s\": 1,\n\"visibility\": 9"), NULL,
     "s.json:4: media[0].visibility: the key \"preset\" is missing beside it"},
    {MEDIUM("\"sigma_s\": 1"), NULL, "s.json:3: media[0]: a homogeneous medium needs the key \"bounds\""},
    {MEDIUM("\"sigma_s\": 1, \"bounds\": [[0,0,0],[1,0,1]]"), NULL,
     "s.json:3: media[0].bounds: the second corner must be above the first along y"},
    {MEDIUM("\"sigma_s\": 1, \"bounds\": [[0,0,0]]"), NULL, "s.json:3: media[0].bounds: expected 2 items, found 1"},
    {MEDIUM("\"sigma_s\": 1, \"bounds\": {\"spere\": {}}"), NULL,
     "s.json:3: media[0].bounds.spere: unknown key; did you mean \"sphere\"?"},
    {MEDIUM("\"sigma_s\": 1, \"bounds\": {\"sphere\": {\"center\": [0,0,0], \"radius\": 0}}"), NULL,
     "s.json:3: media[0].bounds.sphere.radius: 0 is outside (0, 1e+09]"},
    {MEDIUM("\"sigma_s\": 1, " BOX ",\n\"transform\": {\"scale\": 0}"), NULL,
     "s.json:4: media[0].transform.scale: 0 is outside (0, 1e+06]"},
    {MEDIUM("\"sigma_s\": 1, " BOX ",\n\"transform\": [1,0,0,0, 0,1,0,0, 0,0,1,0, 1,2,3,1]"), NULL,
     "s.json:4: media[0].transform: the last row of the matrix must be 0, 0, 0, 1"},
    {MEDIUM("\"sigma_s\": 1, " BOX ",\n\"transform\": [1,0,0,0, 0,0,0,0, 0,0,1,0, 0,0,0,1]"), NULL,
     "s.json:4: media[0].transform: the matrix cannot be inverted"},
    {MEDIUM("\"sigma_s\": 1, " BOX ",\n\"transform\": [1,0,0]"), NULL,
     "s.json:4: media[0].transform: expected 16 items, found 3"},
    {MEDIUM("\"sigma_s\": 1,\n\"density\": {}"), NULL,
     "s.json:4: media[0].density: one of the keys \"file\", \"noise\", \"exponential\" is missing"},
    {MEDIUM("\"sigma_s\": 1,\n\"density\": {\"file\": \"a.vdb\", \"noise\": {}}"), NULL,
     "s.json:4: media[0].density.noise: does not go with \"file\""},
    {MEDIUM("\"sigma_s\": 1, \"density\": {\"noise\": {}}"), NULL,
     "s.json:3: media[0]: noise needs bounds that are a box..."},
    {MEDIUM("\"sigma_s\": 1, \"density\": {\"noise\": {}},\n\"bounds\": {\"sphere\": {\"center\": [0,0,0], \"radius\": "
            "1}}"),
     NULL, "s.json:4: media[0].bounds: noise needs bounds that are a box..."},
    {MEDIUM("\"sigma_s\": 1, \"density\": {\"exponential\": {\"scale_height\": 1}}"), NULL,
     "s.json:3: media[0]: exponential density needs bounds that are a box..."},
    {MEDIUM("\"sigma_s\": 1, " BOX ",\n\"density\": {\"exponential\": {\"scale_height\": 1, \"base\": 50}}"), NULL,
     "s.json:4: media[0].density.exponential: base: it is ..."},
    {MEDIUM("\"sigma_s\": 1, " BOX ", \"density\": {\"noise\": {\"kind\": \"clod\"}}"), NULL,
     "s.json:3: media[0].density.noise.kind: \"clod\" is not one of \"cloud\", \"nebula\", \"fbm\", \"constant\"; did "
     "you mean "
     "\"cloud\"?"},
    {MEDIUM("\"sigma_s\": 1, " BOX ", \"density\": {\"noise\": {\"resolution\": 2048}}"), NULL,
     "s.json:3: media[0].density.noise.resolution: more than 2^31 voxels in all"},
    {MEDIUM("\"sigma_s\": 1, " BOX ", \"density\": {\"noise\": {\"octaves\": 13}}"), NULL,
     "s.json:3: media[0].density.noise.octaves: 13 is outside [1, 12]"},
    /* volumes */
    {HEAD "\"frame\": -1}", NULL, "s.json:2: frame: -1 is outside [0, 2147483647]"},
    {DENSITY("\"file\": \"a.nrrd\", \"frame\": -1"), NULL,
     "s.json:4: media[0].density.frame: -1 is outside [0, 2147483647]"},
    {DENSITY("\"grid\": \"density\""), NULL, "s.json:4: media[0].density: the key \"file\" is missing"},
    {DENSITY("\"file\": \"a.vdb\", \"gird\": \"a\""), NULL,
     "s.json:4: media[0].density.gird: unknown key; did you mean \"grid\"?"},
    {DENSITY("\"file\": \"a.dat\""), NULL,
     "s.json:4: media[0].density.file: cannot read volumes of this type; known: .vdb, .nvdb, .nrrd, .nhdr, .vti, .vtk, "
     ".nc, .dcm and folders of DICOM, .nii, .nii.gz, .hdr, .tif, .vol, .bricks, and any file with the key \"raw\" "
     "beside it"},
    {DENSITY("\"file\": \"a.nrrd\", \"grid\": \"a\""), NULL,
     "s.json:4: media[0].density.grid: is for .vdb, .nvdb, .vti, .vtk and .nc files; others hold one grid"},
    {DENSITY("\"file\": \"gone.nvdb\""), NULL,
     "s.json:4: media[0].density.file: cannot open nowhere/gone.nvdb: No such file or directory"},
    {HEAD "\"frame\": 42, \"media\": [\n{\"sigma_s\": 1, \"density\": {\"file\": \"smoke_####.vdb\"}}]}", NULL,
     "s.json:3: media[0].density.file: cannot open nowhere/smoke_0042.vdb: No such file or directory"},
    {DENSITY("\"file\": \"a_##_b_##.vdb\""), NULL,
     "s.json:4: media[0].density.file: a_##_b_##.vdb: the #s are in more than one place"},
    {DENSITY("\"file\": \"a.raw\", \"raw\": {}"), NULL, "s.json:4: media[0].density.raw: the key \"size\" is missing"},
    {DENSITY("\"file\": \"a.raw\", \"raw\": {\"size\": [2,2,2]}"), NULL,
     "s.json:4: media[0].density: a raw volume without spacing needs bounds that are a box, [[x,y,z],[x,y,z]]"},
    {DENSITY("\"file\": \"a.raw\", \"raw\": {\"size\": [2,2]}"), NULL,
     "s.json:4: media[0].density.raw.size: expected 3 items, found 2"},
    {DENSITY("\"file\": \"a.raw\", \"raw\": {\"size\": [2,0,2]}"), NULL,
     "s.json:4: media[0].density.raw.size[1]: 0 is outside [1, 16384]"},
    {DENSITY("\"file\": \"a.raw\", \"raw\": {\"size\": [2,2,2], \"type\": \"uint61\"}"), NULL,
     "s.json:4: media[0].density.raw.type: \"uint61\" is not one of \"int8\", \"uint8\", \"int16\", \"uint16\", "
     "\"int32\", "
     "\"uint32\", \"int64\", \"uint64\", \"half\", \"float\", \"double\"; did you mean \"uint16\"?"},
    {DENSITY("\"file\": \"a.raw\", \"raw\": {\"size\": [2,2,2], \"spacing\": 0}"), NULL,
     "s.json:4: media[0].density.raw.spacing: 0 is outside (0, 1e+09]"},
    {DENSITY("\"file\": \"a.raw\", \"raw\": {\"size\": [2,2,2], \"offset\": -2}"), NULL,
     "s.json:4: media[0].density.raw.offset: -2 is outside [-1, 9007199254740991]"},
    {DENSITY("\"file\": \"a.nrrd\", \"raw\": {\"size\": [2,2,2]}"), NULL,
     "s.json:4: media[0].density.raw: is for raw files; this one tells what it holds"},
    {DENSITY("\"file\": \"a.vdb\", \"droplets\": {\"effective_radius\": 8}"), NULL,
     "s.json:4: media[0].density.droplets: is for liquid water in .nc files"},
    {DENSITY("\"file\": \"a.nc\", \"droplets\": {\"air_density\": 1}"), NULL,
     "s.json:4: media[0].density.droplets: the key \"effective_radius\" is missing"},
    {MEDIUM("\"sigma_s\": 1, " BOX ",\n\"g\": {\"file\": \"a.nc\", \"droplets\": {\"effective_radius\": 8}}"), NULL,
     "s.json:4: media[0].g.droplets: is for a density; droplets make an extinction"},
    {DENSITY("\"file\": \"a.vdb\", \"component\": 0.5"), NULL,
     "s.json:4: media[0].density.component: expected an integer, found 0.5"},
    /* fields */
    {MEDIUM("\"sigma_s\": 1, " BOX ",\n\"albedo\": {\"file\": \"a.vdb\"}"), NULL,
     "s.json:4: media[0].albedo: does not go with \"sigma_s\"; give sigma_s and sigma_a, or sigma_t and albedo, or "
     "preset"},
    {MEDIUM(BOX ",\n\"albedo\": {\"file\": \"a.vdb\"}"), NULL,
     "s.json:4: media[0].albedo: the key \"sigma_t\" is missing beside it"},
    {MEDIUM("\"sigma_t\": 1, " BOX ",\n\"albedo\": {\"noise\": {}}"), NULL,
     "s.json:4: media[0].albedo.noise: unknown key; known here: \"file\", \"grid\", \"component\", \"frame\", "
     "\"series\", \"storage\", \"raw\", \"droplets\""},
    {MEDIUM("\"sigma_t\": 1, " BOX ",\n\"albedo\": \"white\""), NULL,
     "s.json:4: media[0].albedo: expected a number or an array or an object, found a string"},
    {MEDIUM("\"preset\": \"apple\", " BOX ",\n\"g\": {\"file\": \"a.vdb\"}"), NULL,
     "s.json:4: media[0].g: a volume does not go with \"preset\""},
    {MEDIUM("\"sigma_a\": 1, " BOX ",\n\"emission\": {}"), NULL,
     "s.json:4: media[0].emission: one of the keys \"radiance\", \"temperature\" is missing"},
    {MEDIUM("\"sigma_a\": 1, " BOX ",\n\"emission\": {\"kelvin\": [0, 1]}"), NULL,
     "s.json:4: media[0].emission: the key \"temperature\" is missing"},
    {MEDIUM("\"sigma_a\": 1, " BOX ",\n\"emission\": {\"radiance\": 1, \"scale\": 2}"), NULL,
     "s.json:4: media[0].emission: the key \"temperature\" is missing"},
    {MEDIUM("\"sigma_a\": 1, " BOX ",\n\"emission\": {\"temperature\": {\"file\": \"a.vdb\"}, \"kelvin\": [0, 1, 2]}"),
     NULL, "s.json:4: media[0].emission.kelvin: expected 2 items, found 3"},
    {MEDIUM("\"sigma_a\": 1, " BOX ",\n\"emission\": {\"temperature\": 900}"), NULL,
     "s.json:4: media[0].emission.temperature: expected an object, found 900"},
    {MEDIUM("\"sigma_a\": 1, " BOX ",\n\"emission\": {\"radiance\": -1}"), NULL,
     "s.json:4: media[0].emission.radiance: -1 is outside [0, 1e+09]"},
    /* transfer functions */
    {TRANSFER("\"sigma_s\": 1", "{\"value\": 0, \"density\": 0}"), NULL,
     "s.json:4: media[0].transfer: expected at least 2 items, found 1"},
    {TRANSFER("\"sigma_s\": 1", "{\"value\": 0, \"density\": 0},\n{\"value\": 0, \"density\": 0}"), NULL,
     "s.json:5: media[0].transfer[1].value: 0 is not above the value of the point before, 0"},
    {TRANSFER("\"sigma_s\": 1", "{\"value\": 0.5, \"density\": 0},\n{\"value\": -2.5, \"density\": 0}"), NULL,
     "s.json:5: media[0].transfer[1].value: -2.5 is not above the value of the point before, 0.5"},
    {TRANSFER("\"sigma_t\": 1", "{\"value\": 0, \"density\": 0, \"albedo\": 1},\n{\"value\": 1, \"density\": 0}"), NULL,
     "s.json:5: media[0].transfer[1]: give \"albedo\" in all points or in none"},
    {TRANSFER("\"sigma_s\": 1", "{\"value\": 0, \"density\": 0},\n{\"value\": 1, \"density\": 0, \"albedo\": 1}"), NULL,
     "s.json:5: media[0].transfer[1]: give \"albedo\" in all points or in none"},
    {TRANSFER("\"sigma_s\": 1", POINTS), NULL,
     "s.json:4: media[0].transfer: points with albedo need the key \"sigma_t\" beside it"},
    {TRANSFER("\"sigma_t\": 1, \"albedo\": {\"file\": \"a.vdb\"}", POINTS), NULL,
     "s.json:3: media[0].albedo: the points of \"transfer\" give the albedo already"},
    {TRANSFER("\"sigma_t\": 1, \"albedo\": 0.5", POINTS), NULL,
     "s.json:3: media[0].albedo: the points of \"transfer\" give the albedo already"},
    {TRANSFER("\"sigma_t\": 1", "{\"value\": 0, \"density\": 0}, {\"value\": 1, \"density\": 0}"), NULL,
     "s.json:3: media[0].sigma_t: the key \"albedo\" is missing beside it"},
    {TRANSFER("\"sigma_s\": 1", "{\"value\": 0, \"density\": -1}, {\"value\": 1, \"density\": 0}"), NULL,
     "s.json:4: media[0].transfer[0].density: -1 is outside [0, 1e+09]"},
    {MEDIUM("\"sigma_t\": 1, " BOX ",\n\"transfer\": [" POINTS "]"), NULL,
     "s.json:4: media[0].transfer: there is nothing to look it up with; \"density\" must be a volume or noise"},
    /* closed meshes */
    {MEDIUM("\"sigma_s\": 1,\n\"bounds\": {\"file\": \"gone.glb\"}"), NULL,
     "s.json:4: media[0].bounds.file: cannot open nowhere/gone.glb: No such file or directory"},
    {MEDIUM("\"sigma_s\": 1,\n\"bounds\": {\"file\": \"a.stl\"}"), NULL,
     "s.json:4: media[0].bounds.file: cannot read meshes of this type; known: .gltf, .glb, .obj, .ply"},
    {MEDIUM("\"sigma_s\": 1,\n\"bounds\": {}"), NULL,
     "s.json:4: media[0].bounds: one of the keys \"sphere\", \"file\" is missing"},
    {MEDIUM("\"sigma_s\": 1, \"density\": {\"noise\": {}},\n\"bounds\": {\"file\": \"a.ply\"}"), NULL,
     "s.json:4: media[0].bounds: noise needs bounds that are a box, [[x,y,z],[x,y,z]]"},
    /* lights */
    {LIGHT("\"direction\": [0,-1,0]"), NULL, "s.json:3: lights[0]: the key \"type\" is missing"},
    {LIGHT("\"type\": \"environment\", \"sky\": {\n\"air\": [[0, 0, 0], [9, 1, 9]]}"), NULL,
     "s.json:3: lights[0].sky: air: its box is 1 m high, outside [2, 10000]"},
    {LIGHT("\"type\": \"pont\""), NULL,
     "s.json:3: lights[0].type: \"pont\" is not one of \"directional\", \"point\", \"spot\", "
     "\"area\", \"environment\"; did you mean \"point\"?"},
    {LIGHT("\"type\": \"point\", \"intensity\": 1"), NULL, "s.json:3: lights[0]: the key \"position\" is missing"},
    {LIGHT("\"type\": \"point\", \"position\": [0,0,0],\n\"radiance\": 1"), NULL,
     "s.json:4: lights[0].radiance: does not go with type \"point\""},
    {LIGHT("\"type\": \"directional\", \"direction\": [0,0,0], \"irradiance\": 1"), NULL,
     "s.json:3: lights[0].direction: a direction must not be zero"},
    {LIGHT("\"type\": \"spot\", \"position\": [0,0,0], \"direction\": [0,0,1], \"intensity\": 1, \"cone\": 181"), NULL,
     "s.json:3: lights[0].cone: 181 is outside (0, 180]"},
    {LIGHT("\"type\": \"area\", \"origin\": [0,0,0], \"u\": [1,0,0], \"v\": [2,0,0], \"radiance\": 1"), NULL,
     "s.json:3: lights[0]: the edges u and v span no area"},
    {LIGHT("\"type\": \"environment\""), NULL,
     "s.json:3: lights[0]: one of the keys \"file\", \"radiance\", \"sky\" is missing"},
    {LIGHT("\"type\": \"environment\", \"sky\": {},\n\"rotation\": 1"), NULL,
     "s.json:4: lights[0].rotation: does not go with \"sky\""},
    {LIGHT("\"type\": \"environment\", \"sky\": {\"resolution\": 33}"), NULL,
     "s.json:3: lights[0].sky.resolution: 33 is not a multiple of 2"},
    {LIGHT("\"type\": \"environment\", \"sky\": {\"sun\": 1}"), NULL,
     "s.json:3: lights[0].sky.sun: expected true or false, found 1"},
    {LIGHT("\"type\": \"environment\",\n\"file\": \"gone.hdr\""), NULL,
     "s.json:4: lights[0].file: cannot open nowhere/gone.hdr: No such file..."},
    {LIGHT("\"type\": \"environment\", \"file\": \"\""), NULL, "s.json:3: lights[0].file: is empty"},
    /* geometry */
    {SHAPE("\"material\": {}"), NULL,
     "s.json:3: geometry[0]: one of the keys \"quad\", \"box\", \"sphere\", \"file\" is missing"},
    {SHAPE("\"qaud\": {}"), NULL, "s.json:3: geometry[0].qaud: unknown key; did you mean \"quad\"?"},
    {SHAPE("\"quad\": {\"origin\": [0,0,0], \"u\": [1,0,0]}"), NULL,
     "s.json:3: geometry[0].quad: the key \"v\" is missing"},
    {SHAPE("\"quad\": {\"origin\": [0,0,0], \"u\": [1,0,0], \"v\": [0,0,0]}"), NULL,
     "s.json:3: geometry[0].quad: the edges u and v span no area"},
    {SHAPE("\"box\": [[0,0,0],[1,1,-1]]"), NULL,
     "s.json:3: geometry[0].box: the second corner must be above the first along z"},
    {SHAPE("\"box\": [[0,0,0],[1,1,1]],\n\"material\": {\"albedo\": [0.5, 0.5, 1.01]}"), NULL,
     "s.json:4: geometry[0].material.albedo[2]: 1.01 is outside [0, 1]"},
    {SHAPE("\"sphere\": {\"center\": [0,0,0], \"radius\": 1}, \"transform\": {\"scale\": [1,2,1]}"), NULL,
     "s.json:3: geometry[0]: shape.transform: a sphere takes rotation, translation and uniform scale only"},
    {SHAPE("\"sphere\": {\"center\": [0,0,0], \"radius\": 1}, \"box\": [[0,0,0],[1,1,1]]"), NULL,
     "s.json:3: geometry[0].sphere: does not go with \"box\""},
    {SHAPE("\"file\": \"level.blend\""), NULL,
     "s.json:3: geometry[0].file: cannot read meshes of this type; known: .gltf, .glb, .obj, .ply"},
    {SHAPE("\"file\": \"gone.obj\""), NULL,
     "s.json:3: geometry[0].file: cannot open nowhere/gone.obj: No such file or directory"},
    {SHAPE("\"file\": \"a.obj\",\n\"light_scale\": -1"), NULL,
     "s.json:4: geometry[0].light_scale: -1 is outside [0, 1e+06]"},
    {SHAPE("\"file\": \"a.obj\",\n\"mesh\": true"), NULL,
     "s.json:4: geometry[0].mesh: unknown key; did you mean \"meshes\"?"},
    {SHAPE("\"file\": \"a.obj\",\n\"lights\": 1"), NULL,
     "s.json:4: geometry[0].lights: expected true or false, found 1"},
    {SHAPE("\"box\": [[0,0,0],[1,1,1]],\n\"lights\": true"), NULL,
     "s.json:4: geometry[0].lights: does not go with \"box\""},
    /* cameras of files */
    {HEAD "\"camera\": {\n\"name\": \"front\"}}", NULL, "s.json:3: camera.name: the key \"file\" is missing beside it"},
    {HEAD "\"camera\": {\n\"file\": \"a.obj\"}}", NULL,
     "s.json:3: camera.file: cannot read cameras of files of this type; known: .gltf, .glb"},
    {HEAD "\"camera\": {\n\"file\": \"gone.gltf\"}}", NULL,
     "s.json:3: camera.file: cannot open nowhere/gone.gltf: No such file or directory"},
    /* render */
    {HEAD "\"render\": {\"spp\": 0}}", NULL, "s.json:2: render.spp: 0 is outside [1, 16777216]"},
    {HEAD "\"render\": {\"seed\": -1}}", NULL, "s.json:2: render.seed: -1 is outside [0, 9007199254740991]"},
    {HEAD "\"render\": {\"fld\": {\"streaming\": 1}}}", NULL,
     "s.json:2: render.fld.streaming: unknown key; did you mean \"max_flux_fraction\"?"},
    {HEAD "\"render\": {\"pop\": {\"streaming\": 1}}}", NULL,
     "s.json:2: render.pop.streaming: unknown key; did you mean \"max_flux_fraction\"?"},
    {HEAD "\"render\": {\"pop\": {\"clamp\": 0.1}}}", NULL,
     "s.json:2: render.pop.clamp: unknown key; did you mean \"vpl_min_distance\"?"},
    {HEAD "\"render\": {\"pop\": {\"sharp\": false}}}", NULL,
     "s.json:2: render.pop.sharp: unknown key; did you mean \"fine_lights\"?"},
    {HEAD "\"render\": {\"screen\": {\"filter\": 5}}}", NULL,
     "s.json:2: render.screen.filter: 5 is not a multiple of 2"},
    {HEAD "\"render\": {\"screen\": {\"levels\": 16}}}", NULL,
     "s.json:2: render.screen.levels: 16 is outside [1, 15]; write \"auto\" for the default choice"},
    {HEAD "\"render\": {\n\"dom\": {\"resolution\": 0}}}", NULL,
     "s.json:3: render.dom.resolution: 0 is outside [4, 1024]; write \"auto\" for the default choice"},
    {HEAD "\"render\": {\n\"dom\": {\"resolution\": \"fine\"}}}", NULL,
     "s.json:3: render.dom.resolution: expected an integer or \"auto\", found \"fine\""},
    {HEAD "\"render\": {\n\"dom\": {\"last_directions\": 7}}}", NULL,
     "s.json:3: render.dom.last_directions: 7 is outside [8, 1024]"},
    {HEAD "\"render\": {\"method\": \"pth\"}}", NULL,
     "s.json:2: render.method: \"pth\" is not one of \"auto\", \"path\", \"screen\", \"fld\", \"cda\", \"pop\", "
     "\"lpv\", "
     "\"dom\", \"octaves\"; did you mean \"path\"?"},
    /* values from overrides */
    {HEAD "\"render\": {}}", "render.spp=0", "override \"render.spp=0\": render.spp: 0 is outside [1, 16777216]"},
    {HEAD "\"render\": {}}", "render.spp=x",
     "override \"render.spp=x\": render.spp: expected an integer, found a string"},
    {HEAD "\"render\": {}}", "render.sp=1", "override \"render.sp=1\": render.sp: unknown key; did you mean \"spp\"?"},
    {HEAD "\"render\": {}}", "lights=[{\"type\":\"point\"}]",
     "override \"lights=[{\"type\":\"point\"}]\": lights[0]: the key \"position\" is missing"},
    {HEAD "\"render\": {}}", "camera.up=[0,0,1]",
     "override \"camera.up=[0,0,1]\": camera: up points along the view..."},
    {MEDIUM("\"sigma_s\": 1, " BOX), "media[0].albedo=1",
     "override \"media[0].albedo=1\": media[0].albedo: does not go with..."},
};

/* Overrides that are none. */
static const bad_case bad_overrides[] = {
    {MEDIUM("\"sigma_s\": 1, " BOX), "media[0].g",
     "override \"media[0].g\": expected PATH=VALUE, such as media[0].g=0.5"},
    {MEDIUM("\"sigma_s\": 1, " BOX), "=1", "override \"=1\": expected a path..."},
    {MEDIUM("\"sigma_s\": 1, " BOX), ".a=1", "override \".a=1\": expected a path..."},
    {MEDIUM("\"sigma_s\": 1, " BOX), "a.=1", "override \"a.=1\": expected a path..."},
    {MEDIUM("\"sigma_s\": 1, " BOX), "media[x]=1", "override \"media[x]=1\": expected a path..."},
    {MEDIUM("\"sigma_s\": 1, " BOX), "media[0=1", "override \"media[0=1\": expected a path..."},
    {MEDIUM("\"sigma_s\": 1, " BOX), "media[0]g=1", "override \"media[0]g=1\": expected a path..."},
    {MEDIUM("\"sigma_s\": 1, " BOX), "media[99999999999999999999].g=1",
     "override \"media[99999999999999999999].g=1\": expected a path..."},
    {MEDIUM("\"sigma_s\": 1, " BOX), "a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q=1",
     "override \"a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q=1\": expected a path..."},
    {MEDIUM("\"sigma_s\": 1, " BOX), "media[1].g=0.5", "override \"media[1].g=0.5\": media has 1 element"},
    {MEDIUM("\"sigma_s\": 1, " BOX), "media.g=0.5", "override \"media.g=0.5\": media is an array, not an object"},
    {MEDIUM("\"sigma_s\": 1, " BOX), "media[0].sigma_s.r=0.5",
     "override \"media[0].sigma_s.r=0.5\": media[0].sigma_s is 1, not an object"},
    {MEDIUM("\"sigma_s\": 1, " BOX), "media[0].sigma_s[0]=0.5",
     "override \"media[0].sigma_s[0]=0.5\": media[0].sigma_s is 1, not an array"},
    {MEDIUM("\"sigma_s\": 1, " BOX), "lights[0].radiance=0.5",
     "override \"lights[0].radiance=0.5\": lights has no elements"},
    {MEDIUM("\"sigma_s\": 1, " BOX), "media[0].g=[0.5", "override \"media[0].g=[0.5\": the value is not valid JSON"},
    {MEDIUM("\"sigma_s\": 1, " BOX), "media[0].name=\xff",
     "override \"media[0].name=\xff\": the value is not valid JSON"},
};

static void expect_refusal(const bad_case* row, ty_result expected) {
    const ty_context_def def = ty_default_context_def();
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&def, &context), TY_OK);
    ty_scene* scene = NULL;
    const ty_result result = ty_scene_parse(context, row->text, strlen(row->text), "s.json", "nowhere", &row->override,
                                            row->override != NULL, &scene);
    const char* message = ty_take_error(context);
    const size_t length = strlen(row->message);
    const bool whole = length < 3 || strcmp(row->message + length - 3, "...") != 0;
    const size_t compared = whole ? strlen(message) + 1 : length - 3;
    if (strncmp(message, row->message, compared) != 0)
        fail_msg("%s\n  gave     %s\n  expected %s", row->text, message, row->message);
    if (result != expected && result != TY_ERROR_FILE) fail_msg("%s: %s", message, ty_result_name(result));
    assert_null(scene);
    ty_context_destroy(context);
}

static void wrong_files_are_refused(void** state) {
    (void)state;
    for (size_t i = 0; i < sizeof bad_cases / sizeof bad_cases[0]; ++i) expect_refusal(&bad_cases[i], TY_ERROR_INPUT);
}

static void wrong_overrides_are_refused(void** state) {
    (void)state;
    for (size_t i = 0; i < sizeof bad_overrides / sizeof bad_overrides[0]; ++i)
        expect_refusal(&bad_overrides[i], TY_ERROR_ARGUMENT);
}

static void an_earlier_message_is_kept(void** state) {
    (void)state;
    const ty_context_def def = ty_default_context_def();
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&def, &context), TY_OK);
    ty_scene* scene = NULL;
    assert_int_equal(ty_scene_parse(context, "{", 1, "first", "", NULL, 0, &scene), TY_ERROR_INPUT);
    const char text[] = LIGHT("\"type\": \"environment\", \"file\": \"gone.hdr\"");
    assert_int_equal(ty_scene_parse(context, text, sizeof text - 1, "second", "", NULL, 0, &scene), TY_ERROR_FILE);
    assert_memory_equal(ty_take_error(context), "first:1:", 8);
    assert_int_equal(ty_scene_parse(context, text, sizeof text - 1, "third", NULL, NULL, 0, &scene), TY_ERROR_INPUT);
    assert_string_equal(ty_take_error(context), "third:3: lights[0].file: this scene may not name files");
    ty_context_destroy(context);
}

static void wrong_calls_are_refused(void** state) {
    (void)state;
    const ty_context_def def = ty_default_context_def();
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&def, &context), TY_OK);
    ty_scene* scene = NULL;
    assert_int_equal(ty_scene_load(context, NULL, NULL, 0, &scene), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_scene_parse(context, NULL, 0, "x", "", NULL, 0, &scene), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_scene_parse(context, "{}", 2, "x", "", NULL, 1, &scene), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_scene_parse(NULL, "{}", 2, "x", "", NULL, 0, &scene), TY_ERROR_ARGUMENT);
    ty_take_error(context);
    assert_int_equal(ty_scene_load(context, "gone.json", NULL, 0, &scene), TY_ERROR_FILE);
    assert_non_null(strstr(ty_take_error(context), "gone.json"));
    assert_int_equal(ty_scene_load(context, "builtin:cube", NULL, 0, &scene), TY_ERROR_INPUT);
    const char* message = ty_take_error(context);
    assert_non_null(strstr(message, "there is no scene \"builtin:cube\"; known: "));
    assert_non_null(strstr(message, " cornell_fog,"));
    assert_null(scene);
    ty_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(wrong_overrides_are_refused),
        cmocka_unit_test(an_earlier_message_is_kept),
        cmocka_unit_test(wrong_calls_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
