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

        static int Paeth(int left, int above, int corner)
        {
            int guess = left + above - corner, a = Math.Abs(guess - left), b = Math.Abs(guess - above), c = Math.Abs(guess - corner);
            return a <= b && a <= c ? left : b <= c ? above : corner;
        }
    }
}
