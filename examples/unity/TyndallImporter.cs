// Applies a bake to the open scene: put it in a folder named Editor, and the files of `tyndall export --for unity` below Assets.
// Menu Tyndall: "Apply lightmaps", "Create light probes", "Fill light probes". docs/engines.md has the order.
using System;
using System.Collections.Generic;
using System.IO;
using UnityEditor;
using UnityEngine;
using UnityEngine.Rendering;

public static class TyndallImporter
{
    [Serializable] class MeshEntry { public string name; public int node; public int primitive; }
    [Serializable] class Lightmap { public string file; public MeshEntry[] meshes; }
    [Serializable] class Export { public string engine; public Lightmap[] lightmaps; public string grid; public string probes; }
    [Serializable] class Probe { public float[] position; public float blocked; public float[] coefficients; }
    [Serializable] class Probes { public string engine; public Probe[] probes; }

    const float Blocked = 0.5f; // probes of which more rays met backs of surfaces are inside of walls

    static string ChooseFolder()
    {
        string path = EditorUtility.OpenFolderPanel("Folder of tyndall export", Application.dataPath, "");
        if (string.IsNullOrEmpty(path)) return null;
        if (!path.StartsWith(Application.dataPath)) throw new ArgumentException(path + " is not below Assets");
        return path;
    }

    static T Read<T>(string path)
    {
        return JsonUtility.FromJson<T>(File.ReadAllText(path));
    }

    static Export ReadExport(string folder)
    {
        Export export = Read<Export>(Path.Combine(folder, "export.json"));
        if (export.engine != "unity") throw new InvalidDataException(folder + ": not an export for Unity");
        return export;
    }

    [MenuItem("Tyndall/Apply lightmaps")]
    static void ApplyLightmaps()
    {
        string folder = ChooseFolder();
        if (folder == null) return;
        Export export = ReadExport(folder);
        string assets = "Assets" + folder.Substring(Application.dataPath.Length) + "/";
        var data = new List<LightmapData>();
        foreach (Lightmap map in export.lightmaps)
        {
            // DDS files are taken as they are: BC6H, linear, first row at v = 0 of Unity's second texture coordinates.
            var texture = AssetDatabase.LoadAssetAtPath<Texture2D>(assets + map.file);
            if (texture == null) throw new FileNotFoundException(assets + map.file);
            foreach (MeshEntry entry in map.meshes)
                foreach (MeshRenderer renderer in UnityEngine.Object.FindObjectsOfType<MeshRenderer>())
                    if (renderer.name == entry.name || renderer.GetComponent<MeshFilter>().sharedMesh.name == entry.name)
                    {
                        renderer.lightmapIndex = data.Count;
                        renderer.lightmapScaleOffset = new Vector4(1, 1, 0, 0);
                        renderer.gameObject.isStatic = true;
                    }
            data.Add(new LightmapData { lightmapColor = texture });
        }
        LightmapSettings.lightmapsMode = LightmapsMode.NonDirectional;
        LightmapSettings.lightmaps = data.ToArray();
    }

    static List<Probe> ReadProbes(string folder)
    {
        Export export = ReadExport(folder);
        string file = !string.IsNullOrEmpty(export.grid) ? export.grid : export.probes;
        if (string.IsNullOrEmpty(file)) throw new InvalidDataException(folder + ": the bake has no probes");
        var list = new List<Probe>();
        foreach (Probe probe in Read<Probes>(Path.Combine(folder, file)).probes)
            if (probe.blocked <= Blocked) list.Add(probe);
        return list;
    }

    static Vector3 PositionOf(Probe probe)
    {
        return new Vector3(probe.position[0], probe.position[1], probe.position[2]);
    }

    [MenuItem("Tyndall/Create light probes")]
    static void CreateProbes()
    {
        string folder = ChooseFolder();
        if (folder == null) return;
        var group = new GameObject("Tyndall light probes").AddComponent<LightProbeGroup>();
        group.probePositions = ReadProbes(folder).ConvertAll(PositionOf).ToArray();
    }

    // After Unity has made its tetrahedra of the probes (Generate Lighting).
    [MenuItem("Tyndall/Fill light probes")]
    static void FillProbes()
    {
        string folder = ChooseFolder();
        if (folder == null) return;
        List<Probe> probes = ReadProbes(folder);
        LightProbes light = LightmapSettings.lightProbes;
        if (light == null) throw new InvalidOperationException("there are no light probes yet: Generate Lighting first");
        SphericalHarmonicsL2[] harmonics = light.bakedProbes;
        for (int i = 0; i < harmonics.Length; ++i)
        {
            Probe nearest = null;
            foreach (Probe probe in probes)
                if (nearest == null || (PositionOf(probe) - light.positions[i]).sqrMagnitude < (PositionOf(nearest) - light.positions[i]).sqrMagnitude)
                    nearest = probe;
            for (int term = 0; term < 9; ++term)
                for (int channel = 0; channel < 3; ++channel)
                    harmonics[i][channel, term] = nearest.coefficients[3 * term + channel];
        }
        light.bakedProbes = harmonics;
        EditorUtility.SetDirty(light);
    }
}
