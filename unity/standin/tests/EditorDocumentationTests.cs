// What the manual tells a newcomer to do is there to be done.
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Text.RegularExpressions;
using Lumivox.Editor;
using NUnit.Framework;
using StandIn;
using UnityEditor;
using UnityEngine;

namespace Lumivox.Tests
{
    public sealed class EditorDocumentationTests
    {
        static IEnumerable<string> Menus()
        {
            const BindingFlags all = BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic;
            var assemblies = new[] { typeof(SelfCheck).Assembly, Assembly.Load("Lumivox.Samples.Editor"), typeof(LumivoxVolume).Assembly };
            foreach (var type in assemblies.SelectMany(assembly => assembly.GetTypes()))
            {
                foreach (var method in type.GetMethods(all))
                    foreach (var item in method.GetCustomAttributes<MenuItem>())
                        if (!item.validate) yield return item.menuItem;
                foreach (var asset in type.GetCustomAttributes<CreateAssetMenuAttribute>()) yield return "Assets/Create/" + asset.menuName;
            }
        }

        [Test]
        public void EveryMenuThatItNamesIsThere()
        {
            var package = Packages.all.First();
            // Those that ask for more end with an ellipsis.
            var menus = Menus().Select(menu => menu.TrimEnd('.', '…').Replace("/", " > ")).ToList();
            var named = 0;
            foreach (var page in Directory.GetFiles(Path.Combine(package, "Documentation~"), "*.md").Append(Path.Combine(package, "README.md")))
            {
                var text = Regex.Replace(File.ReadAllText(page), @"\s+", " ");
                foreach (Match match in Regex.Matches(text, "(Assets|GameObject|Window|Component) > (Create > )?Lumivox > "))
                {
                    var rest = text.Substring(match.Index);
                    Assert.IsTrue(menus.Any(menu => rest.StartsWith(menu) || menu.StartsWith(match.Value) && rest.StartsWith(match.Value + "Samples")), $"{Path.GetFileName(page)} names a menu that is not there: {rest.Substring(0, System.Math.Min(60, rest.Length))}");
                    named++;
                }
            }
            Assert.IsTrue(named > 10, $"it names {named}");
        }
    }
}
