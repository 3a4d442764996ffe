using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Lumivox.Editor")]
[assembly: InternalsVisibleTo("Lumivox.Tests")]
