// The parts of Unity's interfaces that examples/unity/TyndallImporter.cs calls, so that it compiles and runs without Unity, and a
// program that calls its menu: FOLDER (below an Assets folder) is of tyndall export; prints the lightmap of each mesh, the
// positions of the probes, and their harmonics.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Reflection;
using System.Text;
using UnityEditor;
using UnityEngine;
using UnityEngine.Rendering;

namespace UnityEngine
{
    public class Object
    {
        public string name;
        public static readonly List<Object> All = new List<Object>();
        public static T[] FindObjectsOfType<T>() where T : Object
        {
            var found = new List<T>();
            foreach (Object o in All)
                if (o is T) found.Add((T)o);
            return found.ToArray();
        }
    }

    public class GameObject : Object
    {
        public bool isStatic;
        readonly List<Component> components = new List<Component>();
        public GameObject(string name) { this.name = name; }
        public T AddComponent<T>() where T : Component, new()
        {
            var component = new T { name = name, gameObject = this };
            components.Add(component);
            All.Add(component);
            return component;
        }
        public T GetComponent<T>() where T : Component { return (T)components.Find(c => c is T); }
    }

    public class Component : Object
    {
        public GameObject gameObject;
        public T GetComponent<T>() where T : Component { return gameObject.GetComponent<T>(); }
    }

    public class Mesh : Object { }
    public class Texture2D : Object { }
    public class MeshFilter : Component { public Mesh sharedMesh; }
    public class MeshRenderer : Component { public int lightmapIndex = -1; public Vector4 lightmapScaleOffset; }
    public class LightProbeGroup : Component { public Vector3[] probePositions; }
    public class LightmapData { public Texture2D lightmapColor; }
    public enum LightmapsMode { NonDirectional, CombinedDirectional }
    public class LightProbes : Object { public SphericalHarmonicsL2[] bakedProbes; public Vector3[] positions; }

    public static class LightmapSettings
    {
        public static LightmapsMode lightmapsMode;
        public static LightmapData[] lightmaps;
        public static LightProbes lightProbes;
    }

    public static class Application { public static string dataPath; }

    public struct Vector3
    {
        public float x, y, z;
        public Vector3(float x, float y, float z) { this.x = x; this.y = y; this.z = z; }
        public float sqrMagnitude { get { return x * x + y * y + z * z; } }
        public static Vector3 operator -(Vector3 a, Vector3 b) { return new Vector3(a.x - b.x, a.y - b.y, a.z - b.z); }
    }

    public struct Vector4 { public Vector4(float x, float y, float z, float w) { } }

    public static class JsonUtility
    {
        static string text;
        static int at;

        public static T FromJson<T>(string json)
        {
            text = json;
            at = 0;
            return (T)Shape(Value(), typeof(T));
        }

        static char Next()
        {
            while (char.IsWhiteSpace(text[at])) ++at;
            return text[at];
        }

        static object Value()
        {
            char c = Next();
            if (c == '"') return Text();
            if (c == '{' || c == '[') return c == '{' ? (object)Members() : Items();
            int begin = at;
            while (at < text.Length && ",]} \r\n\t".IndexOf(text[at]) < 0) ++at;
            string word = text.Substring(begin, at - begin);
            if (word == "true" || word == "false") return word == "true";
            return word == "null" ? null : (object)double.Parse(word, CultureInfo.InvariantCulture);
        }

        static string Text()
        {
            var result = new StringBuilder();
            for (++at; text[at] != '"'; ++at) result.Append(text[at] == '\\' ? text[++at] : text[at]);
            ++at;
            return result.ToString();
        }

        static Dictionary<string, object> Members()
        {
            var result = new Dictionary<string, object>();
            for (++at; Next() != '}';)
            {
                if (Next() == ',') ++at;
                Next();
                string key = Text();
                if (Next() != ':') throw new FormatException("no colon");
                ++at;
                result[key] = Value();
            }
            ++at;
            return result;
        }

        static List<object> Items()
        {
            var result = new List<object>();
            for (++at; Next() != ']';)
            {
                if (Next() == ',') ++at;
                result.Add(Value());
            }
            ++at;
            return result;
        }

        // As Unity does: fields without a key keep their defaults, and keys without a field are passed over.
        static object Shape(object value, Type type)
        {
            if (value == null) return null;
            if (type.IsArray)
            {
                var items = (List<object>)value;
                Array array = Array.CreateInstance(type.GetElementType(), items.Count);
                for (int i = 0; i < items.Count; ++i) array.SetValue(Shape(items[i], type.GetElementType()), i);
                return array;
            }
            if (type == typeof(string) || type.IsPrimitive) return Convert.ChangeType(value, type, CultureInfo.InvariantCulture);
            if (!type.IsSerializable) throw new FormatException(type.Name + " is not Serializable");
            object result = Activator.CreateInstance(type, true);
            foreach (FieldInfo field in type.GetFields())
                if (((Dictionary<string, object>)value).ContainsKey(field.Name))
                    field.SetValue(result, Shape(((Dictionary<string, object>)value)[field.Name], field.FieldType));
            return result;
        }
    }
}

namespace UnityEngine.Rendering
{
    public struct SphericalHarmonicsL2
    {
        float[] values;
        public float this[int channel, int coefficient]
        {
            get { return values[9 * channel + coefficient]; }
            set { (values = values ?? new float[27])[9 * channel + coefficient] = value; }
        }
    }
}

namespace UnityEditor
{
    public class MenuItem : Attribute { public MenuItem(string path) { } }

    public static class EditorUtility
    {
        public static string Chosen;
        public static string OpenFolderPanel(string title, string folder, string name) { return Chosen; }
        public static void SetDirty(UnityEngine.Object o) { }
    }

    public static class AssetDatabase
    {
        public static T LoadAssetAtPath<T>(string path) where T : UnityEngine.Object, new()
        {
            string file = Path.Combine(Path.GetDirectoryName(Application.dataPath), path);
            return File.Exists(file) ? new T { name = path } : null;
        }
    }
}

static class Program
{
    static void Call(string name)
    {
        typeof(TyndallImporter).GetMethod(name, BindingFlags.NonPublic | BindingFlags.Static).Invoke(null, null);
    }

    static void Main(string[] arguments)
    {
        CultureInfo.CurrentCulture = CultureInfo.InvariantCulture;
        EditorUtility.Chosen = arguments[0];
        Application.dataPath = Path.GetDirectoryName(arguments[0]);
        for (int i = 1; i < arguments.Length; ++i)
        {
            var item = new GameObject(arguments[i]);
            item.AddComponent<MeshFilter>().sharedMesh = new Mesh { name = "mesh of it" };
            item.AddComponent<MeshRenderer>();
        }
        Call("ApplyLightmaps");
        foreach (MeshRenderer renderer in UnityEngine.Object.FindObjectsOfType<MeshRenderer>())
            Console.WriteLine("mesh {0} {1}", renderer.name, renderer.lightmapIndex < 0 ? "-" : LightmapSettings.lightmaps[renderer.lightmapIndex].lightmapColor.name);
        Call("CreateProbes");
        Vector3[] positions = UnityEngine.Object.FindObjectsOfType<LightProbeGroup>()[0].probePositions;
        LightmapSettings.lightProbes = new LightProbes { positions = positions, bakedProbes = new SphericalHarmonicsL2[positions.Length] };
        Call("FillProbes");
        for (int i = 0; i < positions.Length; ++i)
        {
            Console.Write("probe {0:R} {1:R} {2:R}", positions[i].x, positions[i].y, positions[i].z);
            for (int k = 0; k < 27; ++k) Console.Write(" {0:R}", LightmapSettings.lightProbes.bakedProbes[i][k % 3, k / 3]);
            Console.WriteLine();
        }
    }
}
