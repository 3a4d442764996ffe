using System.Runtime.CompilerServices;
using UnityEngine.Scripting;

[assembly: InternalsVisibleTo("Lumivox.Tests")]
[assembly: InternalsVisibleTo("StandIn.Tests.Program")]

// No scene names anything in it: the engine alone calls it, and players would be built without.
[assembly: AlwaysLinkAssembly]
