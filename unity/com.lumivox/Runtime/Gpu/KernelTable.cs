// Made by `cargo xtask unity-kernels` from crates/lumivox-shaders: do not edit.

namespace Lumivox
{
    /// <summary>What kernels there are, and by which names they bind.</summary>
    internal static class KernelTable
    {
        /// <summary>What a resource is.</summary>
        internal enum Kind : byte
        {
            /// <summary>A raw buffer.</summary>
            Buffer,
            /// <summary>A texture.</summary>
            Texture,
        }

        /// <summary>A kernel.</summary>
        internal sealed class Entry
        {
            /// <summary>Of its file, and by which recordings call it.</summary>
            internal readonly string Name;
            /// <summary>Of its program; of the fragment program where it is drawn.</summary>
            internal readonly string EntryPoint;
            /// <summary>Whether it is a shader that is drawn, not one that computes.</summary>
            internal readonly bool IsDrawn;
            /// <summary>Its constant buffers, in the order of a recording's uniforms.</summary>
            internal readonly string[] Uniforms;
            /// <summary>Its buffers and textures, in the order of a recording's resources.</summary>
            internal readonly string[] Resources;
            /// <summary>What each of them is.</summary>
            internal readonly Kind[] Kinds;

            internal Entry(string name, string entryPoint, bool isDrawn, string[] uniforms, string[] resources, Kind[] kinds)
            {
                Name = name;
                EntryPoint = entryPoint;
                IsDrawn = isDrawn;
                Uniforms = uniforms;
                Resources = resources;
                Kinds = kinds;
            }
        }

        /// <summary>All of them, by name.</summary>
        internal static readonly Entry[] Entries =
        {
            new Entry("composite_color", "composite_color", true,
                new[] { "params_buffer" },
                new[] { "picture_color" },
                new[] { Kind.Buffer }),
            new Entry("composite_depth", "composite_depth", true,
                new[] { "params_buffer" },
                new[] { "picture_depth" },
                new[] { Kind.Buffer }),
            new Entry("denoise_prepare", "denoise_prepare", false,
                new[] { "params_buffer" },
                new[] { "film", "pixels_2", "kept_picture" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer }),
            new Entry("denoise_wavelet", "denoise_wavelet", false,
                new[] { "params_buffer" },
                new[] { "before", "pixels" },
                new[] { Kind.Buffer, Kind.Buffer }),
            new Entry("empty_space", "empty_space", false,
                new[] { "params_buffer" },
                new[] { "grids", "distances" },
                new[] { Kind.Buffer, Kind.Buffer }),
            new Entry("film_count", "film_count", false,
                new[] { "params_buffer" },
                new[] { "film", "count" },
                new[] { Kind.Buffer, Kind.Buffer }),
            new Entry("film_fade", "film_fade", false,
                new[] { "params_buffer" },
                new[] { "film" },
                new[] { Kind.Buffer }),
            new Entry("host_depth", "host_depth", false,
                new[] { "params_buffer" },
                new[] { "host_depth_map", "film", "restarts" },
                new[] { Kind.Texture, Kind.Buffer, Kind.Buffer }),
            new Entry("light_begin", "light_begin", false,
                new[] { "params_buffer" },
                new[] { "light_cells" },
                new[] { Kind.Buffer }),
            new Entry("light_fill", "light_fill", false,
                new[] { "params_buffer" },
                new[] { "film", "picture", "before", "kept" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer }),
            new Entry("light_gather", "light_gather", false,
                new[] { "params_buffer" },
                new[] { "light_cells", "points_1" },
                new[] { Kind.Buffer, Kind.Buffer }),
            new Entry("light_insert", "light_insert", false,
                new[] { "params_buffer" },
                new[] { "light_cells", "points_1" },
                new[] { Kind.Buffer, Kind.Buffer }),
            new Entry("light_march_surface", "light_march", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "light_cells", "film", "picture", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("light_march_surface_filters", "light_march", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "light_cells", "film", "picture", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("light_march_surface_filters_several", "light_march", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "light_cells", "film", "picture", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("light_march_surface_filters_several_many", "light_march", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "light_cells", "film", "picture", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("light_march_surface_several", "light_march", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "light_cells", "film", "picture", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("light_march_surface_several_many", "light_march", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "light_cells", "film", "picture", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("light_resolve", "light_resolve", false,
                new[] { "params_buffer" },
                new[] { "light_cells" },
                new[] { Kind.Buffer }),
            new Entry("light_smooth", "light_smooth", false,
                new[] { "params_buffer" },
                new[] { "picture" },
                new[] { Kind.Buffer }),
            new Entry("live_picture", "live_picture", false,
                new[] { "params_buffer" },
                new[] { "first_film", "second_film", "first_pixels", "second_pixels", "host_depth_map", "picture_color", "picture_depth" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Buffer, Kind.Buffer }),
            new Entry("majorant_grid", "majorant_grid", false,
                new[] { "params_buffer" },
                new[] { "value_ranges", "range_maxima", "pages", "looks", "label_sets", "depth_ranges", "grids" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Buffer }),
            new Entry("path_trace_live_environment_surface_lights_filters_many_classes_shared", "path_trace", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "environment_map", "film", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("path_trace_live_environment_surface_lights_filters_many_points", "path_trace", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "environment_map", "film", "points_1", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("path_trace_live_environment_surface_lights_filters_many_shared", "path_trace", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "environment_map", "film", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("path_trace_live_environment_surface_lights_filters_points", "path_trace", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "environment_map", "film", "points_1", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("path_trace_live_environment_surface_lights_filters_shared", "path_trace", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "environment_map", "film", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("path_trace_live_environment_surface_lights_many_points", "path_trace", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "environment_map", "film", "points_1", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("path_trace_live_environment_surface_lights_many_shared", "path_trace", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "environment_map", "film", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("path_trace_live_environment_surface_lights_points", "path_trace", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "environment_map", "film", "points_1", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("path_trace_live_environment_surface_lights_shared", "path_trace", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "environment_map", "film", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("path_trace_live_surface_lights_many_points", "path_trace", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "environment_map", "film", "points_1", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("path_trace_live_surface_lights_many_shared", "path_trace", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "environment_map", "film", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("path_trace_live_surface_lights_points", "path_trace", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "environment_map", "film", "points_1", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("path_trace_live_surface_lights_shared", "path_trace", false,
                new[] { "frame_buffer" },
                new[] { "instances", "tables", "grids", "environment_map", "film", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
            new Entry("value_ranges", "value_ranges", false,
                new[] { "params_buffer" },
                new[] { "pages", "ranges", "pool_0_", "pool_1_", "pool_2_", "pool_3_" },
                new[] { Kind.Buffer, Kind.Buffer, Kind.Texture, Kind.Texture, Kind.Texture, Kind.Texture }),
        };
    }
}
