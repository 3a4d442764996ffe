// Small files of pictures: without alpha, each row as differences from what it is most like.
using System;
using System.IO;
using System.IO.Compression;
using UnityEngine;

namespace StandIn
{
    public static class Png
    {
        /// Colours in linear light for the screen; `encode` off leaves them as they are. The first row is the lowest.
        public static byte[] Of(Picture picture, bool encode = true)
        {
            const int bytes = 3;
            int width = picture.width, stride = width * bytes;
            byte[] before = new byte[stride], row = new byte[stride], best = new byte[stride], tried = new byte[stride];
            var rows = new MemoryStream();
            for (var y = picture.height - 1; y >= 0; y--)
            {
                for (var i = 0; i < stride; i++)
                {
                    var color = picture.At(i / bytes, y);
                    var value = (encode ? color.gamma : color)[i % bytes];
                    row[i] = (byte)Math.Round(Mathf.Clamp01(float.IsNaN(value) ? 0 : value) * 255);
                }
                long least = long.MaxValue;
                byte chosen = 0;
                for (byte filter = 0; filter < 5; filter++)
                {
                    long sum = 0;
                    for (var i = 0; i < stride; i++)
                    {
                        int left = i >= bytes ? row[i - bytes] : 0, above = before[i], corner = i >= bytes ? before[i - bytes] : 0;
                        var guess = filter switch { 0 => 0, 1 => left, 2 => above, 3 => (left + above) / 2, _ => Paeth(left, above, corner) };
                        tried[i] = (byte)(row[i] - guess);
                        sum += Math.Abs((int)(sbyte)tried[i]);
                    }
                    if (sum >= least) continue;
                    (least, chosen) = (sum, filter);
                    (best, tried) = (tried, best);
                }
                rows.WriteByte(chosen);
                rows.Write(best, 0, stride);
                (before, row) = (row, before);
            }
            return Picture.Packed(width, picture.height, 2, rows.ToArray());
        }

        /// Those of eight bits a colour, with or without alpha; the first row is the lowest.
        public static bool TryRead(byte[] file, out int width, out int height, out Color32[] pixels)
        {
            width = height = 0;
            pixels = null;
            int Number(int at) => file[at] << 24 | file[at + 1] << 16 | file[at + 2] << 8 | file[at + 3];
            if (file.Length < 33 || Number(0) != unchecked((int)0x89504e47)) return false;
            (width, height) = (Number(16), Number(20));
            var bytes = file[25] == 6 ? 4 : 3;
            if (file[24] != 8 || file[25] != 2 && file[25] != 6 || file[28] != 0) throw new NotImplementedException("the stand-in reads PNG of eight bits a colour only");
            var packed = new MemoryStream();
            for (var at = 8; at + 8 < file.Length; at += Number(at) + 12)
                if (Number(at + 4) == 0x49444154) packed.Write(file, at + 8, Number(at));
            // Past zlib's own header.
            packed.Position = 2;
            var stride = width * bytes;
            byte[] before = new byte[stride], row = new byte[stride];
            pixels = new Color32[width * height];
            using (var rows = new DeflateStream(packed, CompressionMode.Decompress))
                for (var y = height - 1; y >= 0; y--)
                {
                    var filter = rows.ReadByte();
                    for (int got = 0, more; got < stride; got += more)
                        if ((more = rows.Read(row, got, stride - got)) == 0) return false;
                    for (var i = 0; i < stride; i++)
                    {
                        int left = i >= bytes ? row[i - bytes] : 0, above = before[i], corner = i >= bytes ? before[i - bytes] : 0;
                        row[i] += (byte)(filter switch { 0 => 0, 1 => left, 2 => above, 3 => (left + above) / 2, _ => Paeth(left, above, corner) });
                    }
                    for (var x = 0; x < width; x++) pixels[y * width + x] = new Color32(row[x * bytes], row[x * bytes + 1], row[x * bytes + 2], bytes == 4 ? row[x * bytes + 3] : (byte)255);
                    (before, row) = (row, before);
                }
            return true;
        }

        static int Paeth(int left, int above, int corner)
        {
            int guess = left + above - corner, a = Math.Abs(guess - left), b = Math.Abs(guess - above), c = Math.Abs(guess - corner);
            return a <= b && a <= c ? left : b <= c ? above : corner;
        }
    }
}
