using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Lumivox.Tests")]
