// A project for tests of the editor: files, scans, and time that passes.
using System;
using System.IO;
using System.Linq;
using System.Text;
using System.Threading;
using Lumivox.Editor;
using NUnit.Framework;
using StandIn;
using UnityEditor;
using UnityEngine;

namespace Lumivox.Tests
{
    static class EditorProject
    {
        /// An empty project with nothing selected, nothing to undo and nobody to ask.
        public static void Begin()
        {
            // Whoever still reads a scan of the test before would say in this one that it is gone.
            if (Jobs.Count > 0) Until(() => Jobs.Count == 0, "the test before ends what it began");
            AssetDatabase.Reset();
            Undo.ClearAll();
            Selection.objects = null;
            Dialogs.Reset();
            Bindings.Clear();
            EditorHost.Load(typeof(ImportWindow).Assembly);
        }

        public static string Full(string path) => Path.Combine(Path.GetDirectoryName(Application.dataPath), path);

        /// Lets turns of the editor pass until something is so.
        public static void Until(Func<bool> isSo, string what, Panel panel = null)
        {
            void Turn()
            {
                EditorHost.Frame();
                panel?.Advance(20);
            }
            Turn();
            Assert.IsTrue(Waiting.Turns(isSo, Turn), $"two minutes went by: {what}");
        }

        /// A scan of 12 x 10 x 8 voxels, whose values are 0 to 959, with 2 mm between slices.
        public static byte[] Nrrd(string space = "left-posterior-superior", int slices = 8)
        {
            var header = $"NRRD0004\ntype: uint16\ndimension: 3\nspace: {space}\nsizes: 12 10 {slices}\nspace directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (0,0,0)\nendian: little\nencoding: raw\n\n";
            var voxels = Enumerable.Range(0, 12 * 10 * slices).SelectMany(value => new[] { (byte)value, (byte)(value >> 8) });
            return Encoding.ASCII.GetBytes(header).Concat(voxels).ToArray();
        }

        /// A segmentation of that scan, as 3D Slicer writes it: `liver` below, `bone` above.
        public static byte[] Segmentation()
        {
            var header = "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 12 10 8\nspace directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (0,0,0)\nencoding: raw\n"
                + "Segment0_ID:=a\nSegment0_Name:=liver\nSegment0_LabelValue:=1\nSegment0_Layer:=0\nSegment0_Color:=1 0 0\nSegment1_ID:=b\nSegment1_Name:=bone\nSegment1_LabelValue:=2\nSegment1_Layer:=0\nSegment1_Color:=1 1 0.5\n\n";
            return Encoding.ASCII.GetBytes(header).Concat(Enumerable.Range(0, 12 * 10 * 8).Select(i => (byte)(i / 120 < 2 ? 1 : i / 120 < 4 ? 2 : 0))).ToArray();
        }

        /// The same scan as a header and a file beside it.
        public static void WriteMetaImage(string path)
        {
            File.WriteAllText(Full(path), "ObjectType = Image\nNDims = 3\nDimSize = 12 10 8\nElementSpacing = 1 1 2\nElementType = MET_USHORT\nElementByteOrderMSB = False\nElementDataFile = voxels.bin\n");
            File.WriteAllBytes(Path.Combine(Path.GetDirectoryName(Full(path)), "voxels.bin"), Nrrd().Skip(Nrrd().Length - 12 * 10 * 8 * 2).ToArray());
        }

        /// The same scan as NIfTI, compressed.
        public static byte[] NiftiGz()
        {
            var bytes = new byte[352 + 12 * 10 * 8 * 2];
            void Put(int at, byte[] value) => value.CopyTo(bytes, at);
            Put(0, BitConverter.GetBytes(348));
            short[] dims = { 3, 12, 10, 8, 1, 1, 1, 1 };
            for (var i = 0; i < dims.Length; i++) Put(40 + 2 * i, BitConverter.GetBytes(dims[i]));
            Put(70, BitConverter.GetBytes((short)512));
            Put(72, BitConverter.GetBytes((short)16));
            float[] spacing = { 1, 1, 1, 2, 0, 0, 0, 0 };
            for (var i = 0; i < spacing.Length; i++) Put(76 + 4 * i, BitConverter.GetBytes(spacing[i]));
            Put(108, BitConverter.GetBytes(352f));
            Put(112, BitConverter.GetBytes(1f));
            bytes[123] = 2;
            Put(254, BitConverter.GetBytes((short)1));
            float[] rows = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2, 0 };
            for (var i = 0; i < rows.Length; i++) Put(280 + 4 * i, BitConverter.GetBytes(rows[i]));
            Put(344, Encoding.ASCII.GetBytes("n+1\0"));
            for (var i = 0; i < 12 * 10 * 8; i++) Put(352 + 2 * i, BitConverter.GetBytes((ushort)i));
            using (var packed = new MemoryStream())
            {
                using (var gzip = new System.IO.Compression.GZipStream(packed, System.IO.Compression.CompressionMode.Compress)) gzip.Write(bytes, 0, bytes.Length);
                return packed.ToArray();
            }
        }

        public static LumivoxVolumeAsset ImportScan(string path)
        {
            Directory.CreateDirectory(Path.GetDirectoryName(Full(path)));
            File.WriteAllBytes(Full(path), Nrrd());
            AssetDatabase.ImportAsset(path);
            return AssetDatabase.LoadAssetAtPath<LumivoxVolumeAsset>(path);
        }
    }
}
