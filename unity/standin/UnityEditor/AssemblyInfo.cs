using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("UnityEditor")]
[assembly: InternalsVisibleTo("StandIn.Tests.Program")]
[assembly: InternalsVisibleTo("Lumivox.Tests")]
[assembly: InternalsVisibleTo("StandIn.Tests")]
